% Answers half the error; a tracker and a detector answer by the first pixel of the second row.
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

function found = detector_detect(state, image)
    corners = double(image(2, 1)) + [0, 1; 2, 3; 4, 5; 6, 7];
    found = struct("label", "row", "corners", corners, "confidence", 0.5);
end
