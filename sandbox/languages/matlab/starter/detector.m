% A minimal detector as a starting point.
%
% It reports long dark rectangles on brighter sand as boxes: it finds blocks of pixels that are
% much darker than the mean, joins neighbours to regions, and puts a rectangle around each region,
% along its principal axes. All numbers are sums, products, quotients and square roots, which are
% the same on every machine.

function state = detector_setup(config)
    % config: the configuration of the run, without the seed of the trial
    state.block = 3;      % px: side of a block
    state.dark_by = 2;    % standard deviations below the mean
    state.narrowest = 8;  % px: minimum width of a box
    state.plumpest = 2;   % length / width, at least
    state.slimmest = 4.5; % length / width, at most
    state.fullest = 0.5;  % share of the rectangle that is dark, at least
end

function [detections, state] = detector_detect(state, image)
    % called with each image: uint8, rows x columns (x 3 in colour); image(1, 1) is at x = 0, y = 0
    detections = [];
    dark = find_dark(state, image);
    for first = find(dark)'
        if dark(first) && numel(detections) < 64
            [x, y, dark] = take(dark, first);
            detections = [detections, enclose(state, x, y)];
        end
    end
end

function dark = find_dark(state, image)
    % whether each block is dark; columns x rows of the image, with a frame of blocks that are not
    block = state.block;
    % of a colour image the green channel: water absorbs red light first
    pixels = double(image(:, :, ceil(end / 2)))';
    columns = floor(size(pixels, 1) / block);
    rows = floor(size(pixels, 2) / block);
    pixels = reshape(pixels(1:columns * block, 1:rows * block), block, columns, block, rows);
    sums = reshape(sum(sum(pixels, 1), 3), columns, rows);
    average = sum(sums(:)) / numel(sums);
    deviation = sqrt(sum(sums(:) .* sums(:)) / numel(sums) - average * average);
    dark = false(columns + 2, rows + 2);
    dark(2:end - 1, 2:end - 1) = sums < average - state.dark_by * deviation;
end

function [x, y, dark] = take(dark, first)
    % take the dark blocks that are connected with one of them; x and y are counted from 0
    edge = first;
    region = first;
    dark(first) = false;
    while ~isempty(edge)
        near = [edge - 1; edge + 1; edge - size(dark, 1); edge + size(dark, 1)];
        edge = unique(near(dark(near)));
        dark(edge) = false;
        region = [region; edge];
    end
    [x, y] = ind2sub(size(dark), region);
    x = x - 2;
    y = y - 2;
end

function found = enclose(state, x, y)
    % put a rectangle around a region; [] if it is not that of a box
    found = [];
    count = numel(x);
    xx = sum(x .* x) / count - sum(x) / count * (sum(x) / count);
    xy = sum(x .* y) / count - sum(x) / count * (sum(y) / count);
    yy = sum(y .* y) / count - sum(y) / count * (sum(y) / count);
    % u: the first principal axis, an eigenvector of the covariance
    half = (xx - yy) / 2;
    u = [half + sqrt(half * half + xy * xy), xy];
    if all(u == 0)
        u = [0, 1];
    end
    u = u / sqrt(u(1) * u(1) + u(2) * u(2));
    along = x * u(1) + y * u(2);
    across = y * u(1) - x * u(2);
    left = min(along) - 0.5;
    right = max(along) + 0.5;
    top = min(across) - 0.5;
    bottom = max(across) + 0.5;
    len = right - left;
    width = bottom - top;
    share = count / (len * width);
    if width * state.block < state.narrowest || share < state.fullest
        return
    end
    if len < state.plumpest * width || len > state.slimmest * width
        return
    end
    along = [left; right; right; left];  % clockwise
    across = [top; top; bottom; bottom];
    corners = [along * u(1) - across * u(2), along * u(2) + across * u(1)];
    found.label = 'box';
    found.corners = state.block * corners + (state.block - 1) / 2;
    found.confidence = min(share, 1);
end
