% Kinematics of the arms of Seamark: forward, its Jacobian, and inverse.
%
% `seamark init` wrote this file. You may use, modify and distribute it freely; it comes without any
% warranty. Upload it beside your program, in one archive with controller.m:
%
%     arm = arm_kinematics(config.vehicle, config.arm);   % the arm of the run
%     [turn, point] = arm.tool(observation.joints);       % axes as columns; tool centre point [m]
%     [joints, found] = arm.inverse(point, observation.joints);
%     jacobian = arm.jacobian(observation.joints);        % 6 x joints: velocity [m/rad], axis
%     speeds = arm.damped(jacobian(1:3, :), [0; 0; 0.05], 0.05);  % [rad/s]
%
% arm.names, arm.low, arm.high [rad], arm.fastest [rad/s] and arm.home [rad] are columns in the order of
% commands. The base frame is that of the vehicle's body: origin as its file has it, x forward,
% y starboard, z down. p = R q + t takes a point of the inner axes to the outer ones.
function arm = arm_kinematics(vehicle, name)
    arm = numbers_of(name);
    arm.mount = mount_of(vehicle, name);
    data = arm;
    arm.tool = @(joints) walked(data, joints);
    arm.jacobian = @(joints) jacobian_of(data, joints);
    arm.inverse = @(point, start) inverse_of(data, point, start);
    arm.damped = @damped;
end

% Axes of the tool in the body, and its point [m]; of each joint, axis and a point on it.
function [turn, point, axes, origins] = walked(arm, joints)
    axes = zeros(3, numel(arm.low));
    origins = zeros(3, numel(arm.low));
    [turn, point] = inner(eye(3), zeros(3, 1), arm.mount);
    for link = 1:size(arm.chain, 1)
        [turn, point] = inner(turn, point, arm.chain(link, 1:6));
        axis = arm.chain(link, 7:9)';
        motor = arm.chain(link, 10);
        if motor > 0
            axes(:, motor) = turn * axis;
            origins(:, motor) = point;
            turn = turn * about(axis, joints(motor));
        end
    end
    [turn, point] = inner(turn, point, arm.tool);
end

% Geometric Jacobian, 6 x joints: velocity of the tool centre point [m/rad], and axis.
function jacobian = jacobian_of(arm, joints)
    [~, point, axes, origins] = walked(arm, joints);
    jacobian = [cross(axes, point - origins); axes];
end

% Speeds of joints that give about a velocity: damped least squares (Nakamura 1986).
function speeds = damped(ways, velocity, damping)
    speeds = ways' * ((ways * ways' + damping ^ 2 * eye(3)) \ velocity);
end

% Joints within their ranges that bring the tool centre point to a point in the body [m], near `start`
% where a way leads on from there; found is false if no way does, from there, from home, or from
% postures all over the ranges. The tool's direction is what it is then.
function [joints, found] = inverse_of(arm, point, start)
    reaching = arm.chain(arm.chain(:, 10) > 0, 10);  % joints up to the tool
    starts = [start(:), arm.home];
    for posture = 0:2 ^ numel(reaching) - 1
        share = 0.25 + 0.5 * bitget(posture, 1:numel(reaching))';
        first = start(:);
        first(reaching) = arm.low(reaching) + share .* (arm.high(reaching) - arm.low(reaching));
        starts(:, end + 1) = first;
    end
    for first = starts
        [joints, off] = descended(arm, point(:), first);
        found = off <= 1e-7;
        if found
            return
        end
    end
end

% Levenberg and Marquardt; joints at their ends go no further.
function [joints, off] = descended(arm, point, start)
    joints = min(max(start, arm.low), arm.high);
    damping = 0.1;
    [~, at] = walked(arm, joints);
    off = norm(point - at);
    for step = 1:100
        if off <= 1e-7 || damping > 50
            break
        end
        [~, at] = walked(arm, joints);
        jacobian = jacobian_of(arm, joints);
        ways = jacobian(1:3, :);
        stuck = true;
        while any(stuck)
            moves = damped(ways, point - at, damping);
            stuck = (joints >= arm.high & moves > 0) | (joints <= arm.low & moves < 0);
            ways(:, stuck) = 0;
        end
        tried = min(max(joints + moves, arm.low), arm.high);
        [~, at] = walked(arm, tried);
        left = norm(point - at);
        if left < 0.99 * off
            joints = tried;
            off = left;
            damping = max(0.2 * damping, 1e-4);
        else
            damping = 5 * damping;
        end
    end
end

% Axes of a place [x y z roll pitch yaw] that is in others.
function [turn, point] = inner(turn, point, place)
    point = point + turn * place(1:3)';
    turn = turn * about([0; 0; 1], place(6)) * about([0; 1; 0], place(5)) * about([1; 0; 0], place(4));
end

% Rotation about a unit vector (Rodrigues).
function turn = about(axis, angle)
    across = [0, -axis(3), axis(2); axis(3), 0, -axis(1); -axis(2), axis(1), 0];
    turn = eye(3) + sin(angle) * across + (1 - cos(angle)) * across ^ 2;
end

% NUMBERS
