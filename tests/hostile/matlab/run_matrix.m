function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    command = zeros(4, 4);
end
