% Runs inside the box: answers the requests that relay.py passes on, with the functions of the user's
% file. Its arguments are the command of the relay. GNU Octave 7 or later.
1;

function seamark_serve(relay)
    addpath("/tmp/program");  % takes milliseconds: before anybody waits for an answer
    [into, from, process] = popen2(relay{1}, relay(2:end));
    to = [into, process];
    fcntl(from, F_SETFL, 0);  % popen2 makes it non-blocking
    text = fread(from, fread(from, 1, "double"), "char=>char")';
    eval(text);  % filename, main_file, role, floats, config, observe, cameras and sizes
    images = struct();
    stage = "reading";
    state = [];
    try
        path = ["/tmp/program/", main_file];
        if ! strcmp(main_file, "seamark_program.m")
            rehash();  % an archive has other files
        end
        if exist("__parse_file__") == 5
            __parse_file__(path);  % source() alone does not always report the line of a syntax error
        end
        source(path);
        for needed = seamark_functions(role)
            if exist(needed{1}) != 103
                seamark_fail(to, "u", [filename, " does not define ", needed{1}, ". ", seamark_interface(role)], "");
            end
        end
        with_state = nargout(needed{1}) != 1;
        if exist([role, "_setup"]) == 103
            stage = [role, "_setup"];
            state = feval(stage, config);
        end
        fwrite(to(1), [double("k"), 0, 0, 0, 0], "double");
        fflush(to(1));
        while true
            data = fread(from, floats + 1, "double");
            if numel(data) != floats + 1
                exit(70);  % the relay is gone, or the program closed its pipe
            end
            if data(1) == 79  % O
                stage = "controller_step";
                observation = observe(data(2:end));
                if ! isempty(cameras)
                    for k = 1:numel(cameras) * data(end)
                        images.(cameras{k}) = seamark_image(from, [0, sizes(k, :), 1]);
                    end
                    observation.images = images;
                end
                if with_state
                    [command, state] = controller_step(state, observation);
                else
                    command = controller_step(state, observation);
                end
                if isnumeric(command) && numel(command) == 4
                    command = [command(:)', zeros(1, numel(limits) - 4)]; % the joints of an arm rest
                end
                if ! (isnumeric(command) && isreal(command) && numel(command) == numel(limits) && all(abs(command(:)') <= limits))
                    seamark_refuse(to, command, data(2), limits);
                end
                fwrite(to(1), [99; double(full(command(:)))], "double");
            elseif data(1) == 85  % U
                stage = "tracker_update";
                if with_state
                    [corners, state] = tracker_update(state, seamark_image(from, data));
                else
                    corners = tracker_update(state, seamark_image(from, data));
                end
                numbers = seamark_track(to, corners);
                fwrite(to(1), [116; numel(numbers); 0; 0; 0; numbers], "double");
            elseif data(1) == 84  % T
                stage = "tracker_start";
                state = tracker_start(state, seamark_image(from, data), reshape(data(5:12), 2, 4)');
                fwrite(to(1), [double("k"), 0, 0, 0, 0], "double");
            elseif data(1) == 68  % D
                stage = "detector_detect";
                if with_state
                    [found, state] = detector_detect(state, seamark_image(from, data));
                else
                    found = detector_detect(state, seamark_image(from, data));
                end
                numbers = seamark_detections(to, found);
                fwrite(to(1), [100; numel(numbers); 0; 0; 0; numbers], "double");
            elseif data(1) == 82  % R
                stage = [role, "_reset"];
                eval(fread(from, data(2), "char=>char")');
                if exist(stage) == 103
                    state = feval(stage, state, level);
                end
                fwrite(to(1), [double("k"), 0, 0, 0, 0], "double");
            else
                fflush(stdout);
                fflush(stderr);
                fwrite(to(1), [double("q"), 0, 0, 0, 0], "double");
                fflush(to(1));
                exit(0);
            end
            fflush(stdout);
            fflush(to(1));
        end
    catch err
        seamark_report(to, err, {filename, main_file}, stage, role);
    end
end

% The functions that a program of a role has to define; the last one returns the answers.
function names = seamark_functions(role)
    if strcmp(role, "tracker")
        names = {"tracker_start", "tracker_update"};
    elseif strcmp(role, "detector")
        names = {"detector_detect"};
    else
        names = {"controller_step"};
    end
end

function text = seamark_interface(role)
    if strcmp(role, "tracker")
        text = ["A tracker has the functions state = tracker_start(state, image, corners) and ", ...
                "[corners, state] = tracker_update(state, image)"];
    elseif strcmp(role, "detector")
        text = "A detector has the function [detections, state] = detector_detect(state, image)";
    else
        text = "A program has the functions [command, state] = controller_step(state, observation)";
    end
    text = [text, " and, optionally, state = ", role, "_setup(config) and state = ", role, ...
            "_reset(state, level)."];
end

% The image that follows a request: uint8, height x width, or x 3 if it is in colour.
function pixels = seamark_image(from, data)
    pixels = fread(from, data(2) * data(3) * data(4), "uint8=>uint8");
    if data(4) == 1
        pixels = reshape(pixels, data(3), data(2))';
    else
        pixels = permute(reshape(pixels, data(4), data(3), data(2)), [3, 2, 1]);
    end
end

% The eight numbers of corners, none if the target is lost. Wild ones count as a loss outside the box.
function numbers = seamark_track(to, corners)
    numbers = zeros(0, 1);
    if ! (isnumeric(corners) && isempty(corners))
        numbers = seamark_corners(to, corners, Inf, "tracker_update");
    end
end

% The eight numbers of corners whose magnitude is not above a limit; Inf allows NaN too.
function numbers = seamark_corners(to, corners, limit, by)
    good = isnumeric(corners) && isreal(corners) && isequal(size(corners), [4, 2]);
    if ! (good && (isinf(limit) || all(abs(corners(:)) <= limit)))
        if good
            returned_text = mat2str(double(corners), 4);
        else
            returned_text = sprintf("a value of class %s and size %s", class(corners), mat2str(size(corners)));
        end
        if isinf(limit)
            wanted = "finite and real, or [] if the target is lost.";
        else
            wanted = "finite and real.";
        end
        seamark_fail(to, "p", [by, " returned ", returned_text, "; corners are a matrix of 4 rows with x and y ", ...
                               "in px, ", wanted], "");
    end
    numbers = double(full(corners'))(:);
end

% Detections as numbers: corners, confidence, size of the label, its characters.
function numbers = seamark_detections(to, found)
    numbers = zeros(0, 1);
    if isnumeric(found) && isempty(found)
        return
    end
    if ! (isstruct(found) && all(isfield(found, {"label", "corners", "confidence"})) && numel(found) <= 64)
        seamark_fail(to, "p", ["detector_detect must return an array of at most 64 structures with label, ", ...
                               "corners and confidence."], "");
    end
    for one = found(:)'
        sure = one.confidence;
        label = one.label;
        if ! (isnumeric(sure) && isreal(sure) && isscalar(sure) && sure >= 0 && sure <= 1)
            seamark_fail(to, "p", "detector_detect returned a confidence that is not a number from 0 to 1.", "");
        end
        if ! (ischar(label) && isrow(label) && numel(label) <= 64)
            seamark_fail(to, "p", "detector_detect returned a label that is not a text of 1 to 64 bytes.", "");
        end
        corners = seamark_corners(to, one.corners, 1e6, "detector_detect");
        numbers = [numbers; corners; double(sure); numel(label); double(label(:))];
    end
end

% Send the last answer and end.
function seamark_fail(to, letter, sentence, text)
    sentence = uint8(sentence);
    text = uint8(text(1:min(end, 16000)));
    fflush(stdout);
    fwrite(to(1), [double("x"), double(letter), numel(sentence), numel(text), 0], "double");
    fwrite(to(1), sentence, "uint8");
    fwrite(to(1), text, "uint8");
    fflush(to(1));
    waitpid(to(2));  % the box ends with this process: not before the relay has handed the answer on
    exit(1);
end

% Report what was returned instead of a command.
function seamark_refuse(to, command, t, limits)
    if isnumeric(command) && numel(command) == numel(limits)
        returned_text = ["[", strtrim(sprintf("%g ", command)), "]"];
        if ! isreal(command)
            returned_text = "complex numbers";
        end
    else
        returned_text = sprintf("a value of class %s and size %s", class(command), mat2str(size(command)));
    end
    wanted = "four finite real numbers: surge, sway, heave in m/s and yaw rate in rad/s";
    if numel(limits) > 4
        wanted = sprintf(["%d finite real numbers: surge, sway, heave in m/s, yaw rate in rad/s, and the ", ...
                          "speeds of the arm's joints, within%s"], numel(limits), sprintf(" %g", limits(5:end)));
    end
    sentence = sprintf("controller_step returned %s at t = %g s; it must return %s.", returned_text, t, wanted);
    seamark_fail(to, "p", sentence, "");
end

% Report an error of the program with its own lines only. The file has an additional first line, which
% makes it a script file that defines functions.
function seamark_report(to, err, names_of_file, stage, role)
    [filename, main_file] = names_of_file{:};
    message = strtrim(regexprep(err.message, ' near line -?\d+, column -?\d+', ""));
    found = regexp(message, '^parse error near line (\d+) of file', "tokens", "once");
    if strcmp(stage, "reading") && ! isempty(found)
        location = sprintf("%s, line %d: ", filename, str2double(found{1}) - 1);
        message = regexprep(message, '^parse error near line \d+ of file \S+\s*', "");
        seamark_fail(to, "s", [location, strtok(message, "\n")], [location, message, "\n"]);
    end
    own = arrayfun(@(frame) ! isempty(strfind(frame.file, "/tmp/program/")), err.stack);
    frames = err.stack(own);
    text = ["error: ", message, "\n"];
    where = sprintf(" (called as %s). %s", stage, seamark_interface(role));
    for k = numel(frames):-1:1
        main = strcmp(frames(k).file, ["/tmp/program/", main_file]);
        lines{k} = frames(k).line - main;
        names{k} = strrep(strrep(frames(k).file, "/tmp/program/", ""), main_file, filename);
        if lines{k} > 0  % an error in the call itself has no line
            where = sprintf(" (line %d of %s)", lines{k}, names{k});
        end
    end
    for k = 1:min(numel(frames), 30)
        line = sprintf("    %s at line %d of %s\n", frames(k).name, max(lines{k}, 1), names{k});
        text = [text, line];
    end
    letter = "um"(1 + ! isempty(strfind(message, "out of memory")));
    seamark_fail(to, letter, [strtok(message, "\n"), where], text);
end

warning("off", "Octave:shadowed-function");
seamark_serve(argv());
