% A label of 64 KiB.
function [found, state] = detector_detect(state, image)
    found = detection();
    found.label = repmat("x", 1, 65536);
end
