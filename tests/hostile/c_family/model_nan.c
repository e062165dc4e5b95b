typedef struct { double surge; double sway; } ExtY_m_T;
ExtY_m_T m_Y;
void m_initialize(void) {}
void m_step(void) { m_Y.sway = __builtin_nan(""); }
