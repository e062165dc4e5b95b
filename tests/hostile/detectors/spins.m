% Looks for ever.
function [found, state] = detector_detect(state, image)
    while true
        found = detection();
    end
end
