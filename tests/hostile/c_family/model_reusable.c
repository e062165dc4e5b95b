typedef struct { double surge; } ExtY_m_T;
void m_initialize(void *model) {}
void m_step(void *model) {}
