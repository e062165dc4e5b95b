% The built-in PI once more, in MATLAB: the same operations in the same order.
function state = controller_setup(config)
    state.kp = config.kp;
    state.ki = config.ki;
    state.limit = config.reference_limit_m_s;
    state.axes = 2 + config.control_heave;
    state.integral = [0; 0; 0];
end

function state = controller_reset(state, level)
    state.integral = [0; 0; 0];
end

function [command, state] = controller_step(state, observation)
    command = [0; 0; 0; 0];
    for axis = 1:state.axes
        error = observation.error(axis);
        change = 0.0;
        if observation.target_visible
            change = state.ki * error * observation.dt;
        end
        wanted = state.kp * error + state.integral(axis) + change;
        command(axis) = min(max(wanted, -state.limit), state.limit);
        if command(axis) == wanted || (wanted - command(axis)) * change < 0.0
            state.integral(axis) = state.integral(axis) + change;
        end
    end
end
