% Corners beside the plane.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    corners = corners + 1i;
end
