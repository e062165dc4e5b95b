% Moves an arm, as a starting point: keeps the vehicle above its target, the hand open below it.

function [command, state] = controller_step(state, observation)
    % called 20 times per simulated second
    posture = [0; 0.45; 0.6; 0; 0.6];  % rad, of the arm-5e-like: the tool points down
    fastest = 0.3;  % rad/s that all of its motors reach
    velocity = 0.5 * observation.error;  % m/s: forward, starboard, down
    speeds = 2 * (posture - observation.joints);
    speeds = min(max(speeds, -fastest), fastest);  % slew, upper arm, forearm, wrist, jaws
    command = [velocity(1); velocity(2); 0; 0; speeds];
end
