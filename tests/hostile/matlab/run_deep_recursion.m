function x = again(x)
    x = again(x + 1);
end
function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    max_recursion_depth(1e9);
    again(1);
end
