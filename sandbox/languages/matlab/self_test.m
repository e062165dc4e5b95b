% Answers half the error; as a tracker, corners moved by the first pixel of the second row.
function state = controller_setup(config)
    state.gain = 0.5;
    if config.contents
        printf("interpreter\tGNU Octave\t%s\n", version());
    end
end

function [command, state] = controller_step(state, observation)
    command = [state.gain * observation.error; 0.0];
end

function state = tracker_start(state, image, corners)
    state = corners;
end

function corners = tracker_update(state, image)
    corners = state + double(image(2, 1));
end
