% A PI position controller as a starting point.

function state = controller_setup(config)
    % config: the configuration of the run, without the seed of the trial
    state.kp = config.kp;
    state.ki = config.ki;
    state.limit = 0.6;  % m/s
    state.integral = [0; 0; 0];
end

function state = controller_reset(state, level)
    % called at the start of each level, when the vehicle is moved back
    state.integral = [0; 0; 0];
end

function [command, state] = controller_step(state, observation)
    % called 20 times per simulated second
    command = [0; 0; 0; 0];
    if ~observation.target_visible
        return
    end
    error = observation.error;  % m: forward, starboard, down
    state.integral = state.integral + error * observation.dt;
    speed = state.kp * error + state.ki * state.integral;
    speed = max(-state.limit, min(state.limit, speed));
    command = [speed; 0];  % surge, sway, heave m/s and yaw rate rad/s
end
