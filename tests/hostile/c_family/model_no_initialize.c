typedef struct { double surge, x; } ExtY_m_T;
ExtY_m_T m_Y;
void m_step(void) {}
