% Closes all files.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    fclose("all");
end

function state = tracker_start(state, image, corners)
    state.corners = corners;
end
