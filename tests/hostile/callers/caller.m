% Calls a program in MATLAB's language without any guard, and says what it is given.
% Arguments: the program's file, its role. It passes answers on through a file, as a runner does through a pipe.
1;

function report(varargin)
    printf("\nCALLER: %s\n", sprintf(varargin{:}));
    fflush(stdout);
end

% The numbers of detections; says what is wrong with their number and their labels.
function numbers = numbers_of(found)
    numbers = zeros(0, 1);
    if ! isstruct(found) || numel(found) > 64
        report("took %d detections of class %s", numel(found), class(found));
        return
    end
    for one = found(:)'
        if ! ischar(one.label) || numel(one.label) > 64 || any(one.label < 32 | one.label > 126)
            report("took a label of %d bytes", numel(one.label));
        end
        if ! (one.confidence >= 0 && one.confidence <= 1)
            report("took the confidence %g", one.confidence);
        end
        numbers = [numbers; double(one.corners(:)); double(one.confidence)];
    end
end

function call(path, role)
    channel = fopen("/tmp/channel", "w");
    answers = 0;
    report("calls");
    source(path);
    state = [];
    if exist([role, "_setup"]) == 103
        state = feval([role, "_setup"], struct("kp", 0.5));
    end
    corners = [10, 20; 30, 20; 30, 40; 10, 40];
    if strcmp(role, "tracker")
        state = tracker_start(state, zeros(240, 320, "uint8"), corners);
    end
    for step = 0:5
        if strcmp(role, "tracker")
            image = step * ones(240, 320, "uint8");
            [answer, state] = tracker_update(state, image);
            good = isequal(size(answer), [4, 2]);
        elseif strcmp(role, "detector")
            [found, state] = detector_detect(state, step * ones(240, 320, "uint8"));
            answer = numbers_of(found);
            good = true;
        else
            observation = struct("t", step / 20, "error", [0.1, 0.2, 0.3], "depth", 5, "target_visible", true);
            [answer, state] = controller_step(state, observation);
            good = numel(answer) == 4 && isequal(size(answer), [1, 4]);
        end
        if ! (good && isnumeric(answer) && isreal(answer) && all(abs(answer(:)) <= 1e6))
            report("took %s %s", class(answer), disp(answer)(1:min(end, 60)));
        end
        if isnumeric(answer)
            answers = answers + fwrite(channel, double(answer(:)), "double");
        end
    end
    if strcmp(role, "tracker")
        if isfield(state, "image") && any(state.image(:) != step)
            report("the image changed");
        end
    end
    fclose(channel);
    written = stat("/tmp/channel").size / 8;
    honest = struct("controller", 24, "tracker", 48, "detector", 54); % six answers each
    if written != honest.(role)
        report("arrived %d numbers", written);
    end
    report("finished");
end

call(argv(){1}, argv(){2});
