
function state = tracker_start(state, image, corners)
    state.corners = corners;
end
