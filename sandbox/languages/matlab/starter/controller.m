% A PI position controller as a starting point: the law of the built-in PI.

function state = controller_setup(config)
    % config: the configuration of the run, without the seed of the trial
    state.kp = config.kp;
    state.ki = config.ki;
    state.limit = config.reference_limit_m_s;
    state.axes = 2 + config.control_heave;
    state.integral = [0; 0; 0];  % m/s
end

function state = controller_reset(state, level)
    % called at the start of each level, when the vehicle is moved back
    state.integral = [0; 0; 0];
end

function [command, state] = controller_step(state, observation)
    % called 20 times per simulated second
    command = [0; 0; 0; 0];  % surge, sway, heave m/s and yaw rate rad/s
    for axis = 1:state.axes
        error = observation.error(axis);  % m: forward, starboard, down
        change = 0.0;
        if observation.target_visible
            change = state.ki * error * observation.dt;
        end
        wanted = state.kp * error + state.integral(axis) + change;
        command(axis) = min(max(wanted, -state.limit), state.limit);
        % anti-windup: at the limit the integral may only move back inside
        if command(axis) == wanted || (wanted - command(axis)) * change < 0.0
            state.integral(axis) = state.integral(axis) + change;
        end
    end
end
