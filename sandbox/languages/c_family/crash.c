/* Says in which line of the user's source a program crashed. Part of the runner; not part of seamark.h.
 *
 * Without libbacktrace, which comes with GCC on Debian, crashes end the program as they would anyway.
 */
#define _XOPEN_SOURCE 700

#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static void (*report)(const char *sentence);

#if __has_include(<backtrace.h>)
#include <backtrace.h>

enum { STACK_BYTES = 1 << 18, MAX_SENTENCE = 500, GIVE_UP_S = 5 };

static const char PROGRAM[] = "/tmp/program", SOURCE[] = "/tmp/source/";
static char stack[STACK_BYTES]; /* an overflow of the usual one is a crash too */

struct place {
    const char *file, *function;
    int line;
};

static int look(void *found, uintptr_t address, const char *file, int line, const char *function) {
    struct place *place = found;
    (void)address;
    if (!file || strncmp(file, SOURCE, sizeof SOURCE - 1)) return 0;
    place->file = file + sizeof SOURCE - 1, place->line = line, place->function = function;
    return 1; /* the innermost one: no further frames */
}

static void ignore(void *data, const char *message, int number) {
    (void)data, (void)message, (void)number;
}

static const char *because(int number) {
    if (number == SIGSEGV)
        return "SIGSEGV: native code accessed invalid memory, or recursed too deeply";
    if (number == SIGABRT) return "SIGABRT: native code aborted (abort, or an uncaught exception)";
    if (number == SIGFPE) return "SIGFPE: native code divided an integer by zero";
    return number == SIGBUS ? "SIGBUS: native code accessed invalid memory"
                            : "SIGILL: native code executed an invalid instruction";
}

/* If anything goes wrong here, the signal ends the program: its handler is already reset. */
static void on_crash(int number) {
    struct place place = {NULL, NULL, 0};
    char sentence[MAX_SENTENCE];
    alarm(GIVE_UP_S); /* the crashed code may hold a lock that is needed here */
    struct backtrace_state *state = backtrace_create_state(PROGRAM, 0, ignore, NULL);
    if (state) backtrace_full(state, 1, look, ignore, &place);
    if (place.file) {
        snprintf(sentence, sizeof sentence, "The program was ended by %s, in %.100s (line %d of %.200s)",
                 because(number), place.function ? place.function : "a function", place.line,
                 place.file);
        report(sentence);
    }
    raise(number);
}

static void install(void) {
    static const int NUMBERS[] = {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL};
    stack_t own = {.ss_sp = stack, .ss_size = sizeof stack};
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_crash;
    action.sa_flags = SA_ONSTACK | SA_RESETHAND;
    if (sigaltstack(&own, NULL)) return;
    for (size_t i = 0; i < sizeof NUMBERS / sizeof *NUMBERS; i++) sigaction(NUMBERS[i], &action, NULL);
}
#else
static void install(void) {}
#endif

/* Have crashes reported by a function that does not return. */
void seamark_report_crashes(void (*reporter)(const char *sentence)) {
    report = reporter;
    install();
}
