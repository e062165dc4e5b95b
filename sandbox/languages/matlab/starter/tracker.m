% A template tracker in its simplest form: a starting point for your own.
%
% It keeps some pixels of the target and looks for them around its last place: where the sum of
% absolute differences is least, the target is. The mean is taken out of both sides, since turbid
% water adds light of its own. Whole numbers alone: the same answer on every machine.

function state = tracker_setup(config)
    % config: what the form set, without the trial's seed
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
        error("there is no target in the first picture");
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
    % called with each of the next pictures, 20 per simulated second; [] when the target is lost
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
    % the pixels of the grid, one column for each x: without their mean, times their number
    height = size(image, 1);
    right = (0:state.columns - 1) * state.pitch * height;
    down = (0:state.rows - 1)' * state.pitch;
    grid = right + down;
    grid = grid(:);
    pixels = double(image(grid + (y + 1 + x * height)));
    count = numel(grid);
    pixels = count * pixels - sum(pixels, 1);
end
