/*
 * Runs the firmware's binary in simavr, step by step, for the tests.
 *
 * simavr is free software under the GNU General Public License, version 3 or later. This program is
 * linked with it, so it is a tool of the tests only: nothing of it is in the package or in the
 * firmware.
 *
 *     host FIRMWARE.elf
 *
 * Time is counted in cycles of 16 MHz since the start; a restart does not set it back. Each line of
 * input is a command, and is answered by one line.
 *
 *     run CYCLE        run until then, or until the firmware has released the bus. The answer is what
 *                      was sent, a word for each byte, with the cycle at which it is complete:
 *                      hCYCLE:BYTE to the host, bCYCLE:BYTE to the boards; then `released`, if it
 *                      has; then the time
 *     host CYCLE HEX   put bytes on the line from the host, behind those before them, not earlier
 *                      than CYCLE
 *     bus CYCLE HEX    the same on the line from the boards
 *     reset            restart the controller as the host's port does; memory stays as it is
 *     jump             the same without a flag that says why, as behind a boot loader that clears it
 *     power            restart it after a loss of power: memory holds nothing
 *     hang             make the main loop hang where it sleeps next, until the next restart
 *     deaf             the same with interrupts switched off
 *     loader           from now on a restart by the watchdog leaves no flag, as behind a boot loader
 *                      that clears it
 *     stack BOTTOM     paint the memory from this address to the stack; answered by how many bytes
 *                      of the paint are left since the last time
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_regbit.h>

#define HERTZ 16000000
#define ROOM 65536
#define PAINT 0xC5
#define BITS_PER_BYTE 10
#define SELF_LOOP 0xCFFF /* rjmp .-2 */

static FILE *answers;
static avr_t *avr;
static uint64_t before_restart; /* cycles until the last restart */
static uint64_t last_cycle;
static bool released; /* whether the firmware has released the bus since the run began */

/* A line to the controller: bytes with the time at which the first bit of each begins. */
struct line {
    char port;
    struct {
        uint64_t at;
        uint8_t byte;
    } bytes[ROOM];
    unsigned head, tail;
    uint64_t free_at;
    avr_irq_t *to_controller;
};
static struct line from_host = {.port = '0'}, from_boards = {.port = '1'};

static uint64_t now(void)
{
    return before_restart + avr->cycle;
}

static uint64_t cycles_per_byte(char port)
{
    const avr_io_addr_t ubrr = port == '0' ? 0xC4 : 0xCC, status = port == '0' ? 0xC0 : 0xC8;
    const unsigned divisor = avr->data[ubrr] | avr->data[ubrr + 1] << 8;
    return (uint64_t)(divisor + 1) * (avr->data[status] & 2 ? 8 : 16) * BITS_PER_BYTE;
}

/* --- what the firmware sends ------------------------------------------------------------------ */

static void sent(struct avr_irq_t *irq, uint32_t byte, void *param)
{
    (void)irq;
    const char *name = param;
    const uint64_t done = now() + cycles_per_byte(*name == 'h' ? '0' : '1');
    fprintf(answers, " %s%" PRIu64 ":%02x", name, done, byte & 0xFF);
}

static void direction(struct avr_irq_t *irq, uint32_t high, void *param)
{
    (void)irq, (void)param;
    if (!high)
        released = true;
}

/* --- what is sent to it ------------------------------------------------------------------------ */

static void put(struct line *line, uint64_t at, const char *hex)
{
    unsigned byte;
    if (at < line->free_at)
        at = line->free_at;
    for (; sscanf(hex, "%2x", &byte) == 1; hex += 2) {
        line->bytes[line->head % ROOM].at = at;
        line->bytes[line->head++ % ROOM].byte = (uint8_t)byte;
        at += cycles_per_byte(line->port);
    }
    line->free_at = at;
}

static uint64_t due(const struct line *line)
{
    return line->head == line->tail ? UINT64_MAX : line->bytes[line->tail % ROOM].at;
}

static void deliver(struct line *line)
{
    while (due(line) <= now())
        avr_raise_irq(line->to_controller, line->bytes[line->tail++ % ROOM].byte);
}

/* --- running ----------------------------------------------------------------------------------- */

static bool hangs_next, deaf_next;
static uint16_t hung_at, hung_word;

static void hang(void)
{
    if (deaf_next) {
        avr->sreg[S_I] = 0;
        avr->interrupt_state = 0;
        avr->state = cpu_Running;
    }
    hangs_next = deaf_next = false;
    hung_at = (uint16_t)avr->pc;
    hung_word = (uint16_t)(avr->flash[hung_at] | avr->flash[hung_at + 1] << 8);
    avr->flash[hung_at] = SELF_LOOP & 0xFF;
    avr->flash[hung_at + 1] = SELF_LOOP >> 8;
}

static void unhang(void)
{
    if (hung_at == 0)
        return;
    avr->flash[hung_at] = hung_word & 0xFF;
    avr->flash[hung_at + 1] = hung_word >> 8;
    hung_at = 0;
}

static void (*reset_core)(struct avr_t *);
static bool has_loader, has_restarted;

/* The controller restarts, whatever the reason. */
static void restarted(struct avr_t *it)
{
    unhang();
    has_restarted = true;
    if (reset_core != NULL)
        reset_core(it);
}

static avr_cycle_count_t wake(avr_t *it, avr_cycle_count_t when, void *param)
{
    (void)it, (void)when, (void)param;
    return 0;
}

static void no_sleep(avr_t *it, avr_cycle_count_t cycles)
{
    (void)it, (void)cycles;
}

static void run(uint64_t until)
{
    /* A restart sets it again, and a pin that is low is then looked at in every cycle. */
    avr_extint_set_strict_lvl_trig(avr, 4, 0);
    while (now() < until && !released) {
        deliver(&from_host);
        deliver(&from_boards);
        if (avr->state == cpu_Sleeping) {
            if (hangs_next)
                hang();
            uint64_t next = until;
            if (due(&from_host) < next)
                next = due(&from_host);
            if (due(&from_boards) < next)
                next = due(&from_boards);
            avr_cycle_timer_register(avr, next - now(), wake, NULL);
        }
        const int state = avr_run(avr);
        if (has_restarted && has_loader)
            avr_regbit_clear(avr, avr->reset_flags.wdrf);
        has_restarted = false;
        if (avr->cycle < last_cycle) /* some versions of simavr count from 0 after a restart */
            before_restart += last_cycle;
        last_cycle = avr->cycle;
        if (state == cpu_Done || state == cpu_Crashed) {
            fprintf(stderr, "the firmware has crashed at %x\n", (unsigned)avr->pc);
            exit(1);
        }
    }
}

static void restart(avr_regbit_t why)
{
    const uint64_t until = now();
    avr_reset(avr);
    if (why.reg != 0)
        avr_regbit_set(avr, why);
    before_restart = until - avr->cycle;
    last_cycle = avr->cycle;
    from_host.tail = from_host.head;
}

static unsigned paint(unsigned bottom)
{
    unsigned left = 0;
    const unsigned top = (unsigned)(avr->data[R_SPL] | avr->data[R_SPH] << 8);
    while (bottom + left < top && avr->data[bottom + left] == PAINT)
        left++;
    memset(avr->data + bottom, PAINT, top - bottom);
    return left;
}

static avr_irq_t *uart_irq(char port, int which)
{
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS(port), &flags);
    return avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ(port), which);
}

int main(int argc, char **argv)
{
    static char line[2 * ROOM + 64], hex[2 * ROOM];
    elf_firmware_t firmware = {0};
    uint64_t cycle;
    unsigned address;

    answers = fdopen(dup(1), "w"); /* simavr writes lines of its own to the standard output */
    dup2(2, 1);
    if (answers == NULL || argc != 2 || elf_read_firmware(argv[1], &firmware) != 0)
        return 2;
    avr = avr_make_mcu_by_name("atmega2560");
    avr_init(avr);
    firmware.frequency = HERTZ;
    avr_load_firmware(avr, &firmware);
    avr->frequency = HERTZ;
    avr->sleep = no_sleep;
    avr->log = LOG_ERROR;
    reset_core = avr->reset;
    avr->reset = restarted;
    from_host.to_controller = uart_irq('0', UART_IRQ_INPUT);
    from_boards.to_controller = uart_irq('1', UART_IRQ_INPUT);
    avr_irq_register_notify(uart_irq('0', UART_IRQ_OUTPUT), sent, "h");
    avr_irq_register_notify(uart_irq('1', UART_IRQ_OUTPUT), sent, "b");
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('E'), 4), direction, NULL);

    while (fgets(line, sizeof line, stdin)) {
        if (sscanf(line, "run %" SCNu64, &cycle) == 1) {
            released = false;
            run(cycle);
            fprintf(answers, "%s %" PRIu64 "\n", released ? " released" : "", now());
        } else if (sscanf(line, "host %" SCNu64 " %131071s", &cycle, hex) == 2) {
            put(&from_host, cycle, hex);
            fprintf(answers, "\n");
        } else if (sscanf(line, "bus %" SCNu64 " %131071s", &cycle, hex) == 2) {
            put(&from_boards, cycle, hex);
            fprintf(answers, "\n");
        } else if (strncmp(line, "reset", 5) == 0) {
            restart(avr->reset_flags.extrf);
            fprintf(answers, "\n");
        } else if (strncmp(line, "jump", 4) == 0) {
            restart((avr_regbit_t){0});
            fprintf(answers, "\n");
        } else if (strncmp(line, "power", 5) == 0) {
            restart(avr->reset_flags.porf);
            memset(avr->data + 0x200, 0xFF, avr->ramend + 1 - 0x200);
            fprintf(answers, "\n");
        } else if (strncmp(line, "hang", 4) == 0) {
            hangs_next = true;
            fprintf(answers, "\n");
        } else if (strncmp(line, "loader", 6) == 0) {
            has_loader = true;
            fprintf(answers, "\n");
        } else if (strncmp(line, "deaf", 4) == 0) {
            hangs_next = deaf_next = true;
            fprintf(answers, "\n");
        } else if (sscanf(line, "stack %u", &address) == 1) {
            fprintf(answers, "%u\n", paint(address));
        }
        fflush(answers);
    }
    return 0;
}
