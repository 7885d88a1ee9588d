//! Equations of state: pressure, temperature, sound speed and phase from volume and energy; and their fit.
