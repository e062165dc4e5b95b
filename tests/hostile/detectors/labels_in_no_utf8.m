% A label that is not UTF-8.
function [found, state] = detector_detect(state, image)
    found = detection();
    found.label = ["box", char([255, 254])];
end
