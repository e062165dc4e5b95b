function state = controller_setup(config)
    error("no gain: %s", "today");
end
function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    state = [];
end
