% Runs inside the box: answers the questions that inside/octave.py passes on, by the functions of a
% stranger's file. Its arguments are the command of the relay. GNU Octave 7 or later.
1;

function seamark_serve(relay)
    [to, from] = popen2(relay{1}, relay(2:end));
    fcntl(from, F_SETFL, 0);  % popen2 makes it non-blocking
    text = fread(from, fread(from, 1, "double"), "char=>char")';
    eval(text);  % filename, floats, config and observe
    stage = "reading";
    state = [];
    try
        path = ["/tmp/program/", filename];
        addpath("/tmp/program");
        if exist("__parse_file__") == 5
            __parse_file__(path);  % source alone does not always say where the text is wrong
        end
        source(path);
        if exist("controller_step") != 103
            seamark_fail(to, "u", [filename, " does not define controller_step. ", seamark_interface()], "");
        end
        if exist("controller_setup") == 103
            stage = "controller_setup";
            state = controller_setup(config);
        end
        with_state = nargout("controller_step") != 1;
        fwrite(to, [double("k"), 0, 0, 0, 0], "double");
        fflush(to);
        while true
            data = fread(from, floats + 1, "double");
            if numel(data) != floats + 1
                exit(70);  % the relay is gone, or the program closed its pipe
            end
            if data(1) == 79  % O
                stage = "controller_step";
                if with_state
                    [command, state] = controller_step(state, observe(data(2:end)));
                else
                    command = controller_step(state, observe(data(2:end)));
                end
                if ! (isnumeric(command) && isreal(command) && numel(command) == 4 && all(abs(command(:)) <= 1e6))
                    seamark_refuse(to, command, data(2));
                end
                fwrite(to, [99; double(full(command(:)))], "double");
            elseif data(1) == 82  % R
                stage = "controller_reset";
                eval(fread(from, data(2), "char=>char")');
                if exist("controller_reset") == 103
                    state = controller_reset(state, level);
                end
                fwrite(to, [double("k"), 0, 0, 0, 0], "double");
            else
                fflush(stdout);
                fflush(stderr);
                fwrite(to, [double("q"), 0, 0, 0, 0], "double");
                fflush(to);
                exit(0);
            end
            fflush(stdout);
            fflush(to);
        end
    catch err
        seamark_report(to, err, filename, stage);
    end
end

function text = seamark_interface()
    text = ["A program has the functions [command, state] = controller_step(state, observation) ", ...
            "and, if it likes, state = controller_setup(config) and ", ...
            "state = controller_reset(state, level)."];
end

% Send the last answer and end.
function seamark_fail(to, letter, sentence, text)
    sentence = uint8(sentence);
    text = uint8(text(1:min(end, 16000)));
    fflush(stdout);
    fwrite(to, [double("x"), double(letter), numel(sentence), numel(text), 0], "double");
    fwrite(to, sentence, "uint8");
    fwrite(to, text, "uint8");
    fflush(to);
    exit(1);
end

% Say what came in the place of a command.
function seamark_refuse(to, command, t)
    if isnumeric(command) && numel(command) == 4
        came = ["[", strtrim(sprintf("%g ", command)), "]"];
        if ! isreal(command)
            came = "four complex numbers";
        end
    else
        came = sprintf("a value of class %s and size %s", class(command), mat2str(size(command)));
    end
    sentence = sprintf(["controller_step returned %s at t = %g s; it must return four finite real ", ...
                        "numbers: surge, sway, heave in m/s and yaw rate in rad/s."], came, t);
    seamark_fail(to, "p", sentence, "");
end

% Report an error of the program with its own lines alone. The file has one line more than its
% author wrote: the first, which makes it a file of functions.
function seamark_report(to, err, filename, stage)
    message = strtrim(regexprep(err.message, ' near line -?\d+, column -?\d+', ""));
    found = regexp(message, '^parse error near line (\d+) of file', "tokens", "once");
    if strcmp(stage, "reading") && ! isempty(found)
        place = sprintf("%s, line %d: ", filename, str2double(found{1}) - 1);
        message = regexprep(message, '^parse error near line \d+ of file \S+\s*', "");
        seamark_fail(to, "s", [place, strtok(message, "\n")], [place, message, "\n"]);
    end
    own = arrayfun(@(frame) ! isempty(strfind(frame.file, "/tmp/program/")), err.stack);
    frames = err.stack(own);
    text = ["error: ", message, "\n"];
    where = sprintf(" (called as %s). %s", stage, seamark_interface());
    for k = numel(frames):-1:1
        main = strcmp(frames(k).file, ["/tmp/program/", filename]);
        lines{k} = frames(k).line - main;
        names{k} = strrep(frames(k).file, "/tmp/program/", "");
        if lines{k} > 0  % an error at the call itself has no line
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
