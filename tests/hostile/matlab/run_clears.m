function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    clear all
    command = [0, 0, 0, 0];
    state = [];
end
