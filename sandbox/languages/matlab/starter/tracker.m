% A minimal template tracker as a starting point.
%
% It stores some pixels of the target and searches around the last position for the smallest sum of
% absolute differences. Means are subtracted, since turbid water adds scattered light. Integer
% arithmetic gives the same result on every machine.

function state = tracker_setup(config)
    % config: the configuration of the run, without the seed of the trial
    state.points = 1200;  % pixels of the target, at most
    state.reach = 8;      % px: how far it is looked for
end

function state = tracker_start(state, image, corners)
    % called at the start of each level; image: uint8, rows x columns; corners: x and y [px] of the
    % upper left, upper right, lower right and lower left one. image(1, 1) is at x = 0, y = 0.
    [height, width] = size(image);
    state.corners = corners;
    state.left = max(ceil(min(corners(:, 1))), 0);
    state.top = max(ceil(min(corners(:, 2))), 0);
    width = min(floor(max(corners(:, 1))), width - 1) - state.left;
    height = min(floor(max(corners(:, 2))), height - 1) - state.top;
    if width < 1 || height < 1
        error("there is no target in the first image");
    end
    state.pitch = 1;
    while floor(width / state.pitch) * floor(height / state.pitch) > state.points
        state.pitch = state.pitch + 1;
    end
    state.columns = floor(width / state.pitch);
    state.rows = floor(height / state.pitch);
    state.patch = look(state, image, state.left, state.top);
    state.contrast = sum(abs(state.patch));
end

function [corners, state] = tracker_update(state, image)
    % called with each following image, 20 per simulated second; returns [] if the target is lost
    corners = [];
    [height, width] = size(image);
    last_x = min(state.left + state.reach, width - state.columns * state.pitch);
    last_y = min(state.top + state.reach, height - state.rows * state.pitch);
    x = max(state.left - state.reach, 0):last_x;
    best = Inf;
    for y = max(state.top - state.reach, 0):last_y
        difference = sum(abs(look(state, image, x, y) - state.patch), 1);
        [least, at] = min(difference);
        if least < best
            best = least;
            found = [x(at), y];
        end
    end
    if isinf(best) || 10 * best > 9 * state.contrast
        return
    end
    state.corners = state.corners + (found - [state.left, state.top]);
    state.left = found(1);
    state.top = found(2);
    corners = state.corners;
end

function pixels = look(state, image, x, y)
    % the pixels of the grid, one column for each x: minus their mean, times their number
    height = size(image, 1);
    right = (0:state.columns - 1) * state.pitch * height;
    down = (0:state.rows - 1)' * state.pitch;
    grid = right + down;
    grid = grid(:);
    pixels = double(image(grid + (y + 1 + x * height)));
    count = numel(grid);
    pixels = count * pixels - sum(pixels, 1);
end
