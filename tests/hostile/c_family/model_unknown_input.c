typedef struct { double surge; double sway; } ExtY_m_T;
typedef struct { double eror_x; } ExtU_m_T;
ExtU_m_T m_U;
ExtY_m_T m_Y;
void m_initialize(void) {}
void m_step(void) {}
