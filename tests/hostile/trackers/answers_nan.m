% A corner that is no number.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    corners(3, 1) = NaN;
end
