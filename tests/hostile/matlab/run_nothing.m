function controller_step(state, observation)
end
