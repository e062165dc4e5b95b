% A corner that is no number.
function [found, state] = detector_detect(state, image)
    found = detection();
    found.corners(3, 1) = NaN;
end
