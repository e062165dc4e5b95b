typedef struct { double error[3]; } ExtU_m_T;
ExtU_m_T m_U;
void m_initialize(void) {}
void m_step(void) {}
