function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    command = [1, 2, 3];
end
