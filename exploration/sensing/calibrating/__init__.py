"""From frames of known things (air, a flat, an edge, a step, a weight) to a calibration with its sigmas."""
