function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    while true
        if fork() < 0
            error("no more processes");
        end
    end
end
