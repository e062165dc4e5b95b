function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    kept = {};
    while true
        kept{end + 1} = ones(3000);
    end
end
