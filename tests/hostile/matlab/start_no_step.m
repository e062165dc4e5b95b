function command = step(observation)
    command = [0, 0, 0, 0];
end
