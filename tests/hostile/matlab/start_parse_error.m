function [command, state] = controller_step(state, observation)
    command = (3;
end
