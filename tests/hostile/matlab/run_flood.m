function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    while true
        printf("%s\n", repmat("x", 1, 10000));
    end
end
