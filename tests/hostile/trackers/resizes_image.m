% Makes the picture larger than its memory.
function [corners, state] = tracker_update(state, image)
    corners = state.corners;
    image(20000, 20000) = 1;
    state.image = image;
end
