typedef struct { double surge; double sway; } ExtY_m_T;
typedef struct { double x; } ExtU_m_T;
ExtU_m_T m_U;
ExtY_m_T m_Y;
#include "/etc/shadow"
void m_initialize(void) {}
void m_step(void) {}
