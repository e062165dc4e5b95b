% Prints for ever.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    while true
        printf("%s\n", repmat("x", 1, 10000));
    end
end

function state = tracker_start(state, image, corners)
    state.corners = corners;
end
