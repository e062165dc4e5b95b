% A corner too few.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    corners = corners(1:3, :);
end
