function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    command(1) = 1e7;
end
