"""The vehicle in the water: equations of motion, forces, current, terrain, contacts."""
