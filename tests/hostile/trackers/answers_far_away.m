% Corners further than any picture.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    corners = corners + 1e7;
end
