% A matrix that fits nowhere.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    corners = ones(1e5, 2);
end
