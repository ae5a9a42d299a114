/* A small device that is none: its serial line is stdin and stdout, or a terminal of its own.

   device             speaks on stdin and stdout
   device --pty       makes a terminal, prints its name, and speaks there
   device [--pty] 7   shares its line with others: takes what is sent to the address 7
   device [--pty] 1 20
                      is twenty devices on one line, a process each; tells which

   What it has is the part of the conformance suite's subject that small devices are asked for. */

#define _XOPEN_SOURCE 600

#include "ps_line.h"

#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#define POLL_MS 5

static uint32_t milliseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint32_t)((uint64_t)now.tv_sec * 1000u + (uint64_t)now.tv_nsec / 1000000u);
}

/* What it knows */

static int32_t speed = 250, count = 7, angle = 3, joint = 500, clamped = 5, blank = 1, presses;
static int32_t location[6] = {1000, 2000, 0, 0, 0, 500}, colour[3] = {1, 0, 0};
static uint8_t mode, is_on = 1, fussy;
static char name[24] = "rover", label[24] = "two words";
static const char *const MODES[] = {"idle", "drive"}, *const FLAGS[] = {"false", "true"};
static const char *const TASTES[] = {"even", "odd", "gone"};

static enum ps_code get_vector(const struct ps_property *property, struct ps_text *value)
{
    const struct ps_number *first = property->of;
    uint8_t size = first->decimals != 0 ? 6 : 3;
    for (uint8_t i = 0; i < size; i++) {
        ps_put(value, i == 0 ? "(" : " ");
        ps_put_number(value, first->number[i], first->decimals);
    }
    ps_put(value, ")");
    return PS_OK;
}

static enum ps_code get_text(const struct ps_property *property, struct ps_text *value)
{
    ps_put(value, property->of);
    return PS_OK;
}

static enum ps_code get_uptime(const struct ps_property *property, struct ps_text *value)
{
    (void)property;
    ps_put_number(value, (int32_t)(milliseconds() / 100u), 1);
    return PS_OK;
}

static enum ps_code get_broken(const struct ps_property *property, struct ps_text *value)
{
    (void)property;
    (void)value;
    return PS_INTERNAL;
}

static enum ps_code set_clamped(const struct ps_property *property, const char *value)
{
    enum ps_code code = ps_set_number(property, value);
    clamped = clamped > 10 ? 10 : clamped;
    return code;
}

static enum ps_code set_fussy(const struct ps_property *property, const char *value)
{
    uint8_t taste = 0;
    enum ps_code code = ps_take_word(value, TASTES, 3, &taste);
    (void)property;
    return code != PS_OK ? code : taste == 1 ? PS_BAD_VALUE : taste == 2 ? PS_INTERNAL : PS_OK;
}

static enum ps_code set_press(const struct ps_property *property, const char *value)
{
    (void)property;
    if (strcmp(value, "true") != 0)
        return PS_BAD_VALUE;
    presses++;
    return PS_OK;
}

static enum ps_code set_grip(const struct ps_property *property, const char *value)
{
    static bool is_ready = true;
    (void)property;
    (void)value;
    is_ready = !is_ready; /* each time it moves on, it is asked once too often */
    return is_ready ? PS_OK : PS_BUSY;
}

static enum ps_code set_door_code(const struct ps_property *property, const char *value)
{
    static const char *const CODES[] = {"sesame"};
    uint8_t ignored;
    (void)property;
    return ps_take_word(value, CODES, 1, &ignored);
}

#define ANY INT32_MIN + 1, INT32_MAX
static const struct ps_number SPEED = {&speed, -1000, 1000, 3}, COUNT = {&count, ANY, 0},
                              ANGLE = {&angle, ANY, 0}, JOINT = {&joint, ANY, 3},
                              CLAMPED = {&clamped, ANY, 0}, BLANK = {&blank, ANY, 0},
                              PRESSES = {&presses, ANY, 0};
static const struct ps_number LOCATION[] = {
    {&location[0], ANY, 3}, {&location[1], ANY, 3}, {&location[2], ANY, 3},
    {&location[3], ANY, 3}, {&location[4], ANY, 3}, {&location[5], ANY, 3}};
static const struct ps_number COLOUR[] = {
    {&colour[0], 0, 255, 0}, {&colour[1], 0, 255, 0}, {&colour[2], 0, 255, 0}};
static const struct ps_choice MODE = {&mode, MODES, 2}, IS_ON = {&is_on, FLAGS, 2},
                              FUSSY = {&fussy, TASTES, 3};
static const struct ps_string NAME = {name, sizeof name}, LABEL = {label, sizeof label};

static const struct ps_property TABLE[] = {
    {"speed", ps_get_number, ps_set_number, &SPEED},
    {"location", get_vector, NULL, &LOCATION[0]},
    {"location.x", ps_get_number, ps_set_number, &LOCATION[0]},
    {"location.y", ps_get_number, ps_set_number, &LOCATION[1]},
    {"location.z", ps_get_number, ps_set_number, &LOCATION[2]},
    {"location.a", ps_get_number, ps_set_number, &LOCATION[3]},
    {"location.b", ps_get_number, ps_set_number, &LOCATION[4]},
    {"location.c", ps_get_number, ps_set_number, &LOCATION[5]},
    {"colour", get_vector, NULL, &COLOUR[0]},
    {"colour.r", ps_get_number, ps_set_number, &COLOUR[0]},
    {"colour.g", ps_get_number, ps_set_number, &COLOUR[1]},
    {"colour.b", ps_get_number, ps_set_number, &COLOUR[2]},
    {"mode", ps_get_choice, ps_set_choice, &MODE},
    {"name", ps_get_string, ps_set_string, &NAME},
    {"label", ps_get_string, ps_set_string, &LABEL},
    {"is_on", ps_get_choice, ps_set_choice, &IS_ON},
    {"count", ps_get_number, ps_set_number, &COUNT},
    {"notes", get_text, NULL, "plain (text"},
    {"arm.angle", ps_get_number, ps_set_number, &ANGLE},
    {"arm.joint.1", ps_get_number, ps_set_number, &JOINT},
    {"image.jpg", get_text, NULL, "not a picture"},
    {"a%20b", ps_get_number, ps_set_number, &BLANK},
    {"serial", get_text, NULL, "X1"},
    {"grip", NULL, set_grip, NULL},
    {"door_code", NULL, set_door_code, NULL},
    {"broken", get_broken, NULL, NULL},
    {"clamped", ps_get_number, set_clamped, &CLAMPED},
    {"fussy", ps_get_choice, set_fussy, &FUSSY},
    {"button.press", NULL, set_press, NULL},
    {"button.presses", ps_get_number, NULL, &PRESSES},
    {"uptime", get_uptime, NULL, NULL},
};

/* Its line */

static char waiting[512];
static size_t waits;

static void flush(int fd)
{
    const char *at = waiting;
    while (waits != 0) {
        ssize_t sent = write(fd, at, waits);
        if (sent < 0)
            exit(0); /* the far side has gone */
        at += sent;
        waits -= (size_t)sent;
    }
}

static void send_byte(void *context, char byte)
{
    if (waits == sizeof waiting)
        flush(*(const int *)context);
    waiting[waits++] = byte;
}

static void make_raw(int fd)
{
    struct termios settings;
    if (tcgetattr(fd, &settings) != 0)
        return; /* no terminal */
    settings.c_iflag = 0;
    settings.c_oflag = 0;
    settings.c_lflag = 0;
    settings.c_cc[VMIN] = 1;
    settings.c_cc[VTIME] = 0;
    tcsetattr(fd, TCSANOW, &settings);
}

static int own_terminal(void)
{
    int fd = posix_openpt(O_RDWR | O_NOCTTY);
    if (fd < 0 || grantpt(fd) != 0 || unlockpt(fd) != 0) {
        perror("device: no terminal");
        exit(1);
    }
    printf("%s\n", ptsname(fd));
    fflush(stdout);
    /* Held open, so that clients may come and go. */
    make_raw(open(ptsname(fd), O_RDWR | O_NOCTTY));
    return fd;
}

static void be_device(int in, int out, const char *address)
{
    static struct ps ps;
    make_raw(in);
    ps_init(&ps, TABLE, sizeof TABLE / sizeof TABLE[0], send_byte, &out);
    if (address != NULL)
        ps_share(&ps, address);
    for (;;) {
        struct pollfd one = {in, POLLIN, 0};
        char bytes[256];
        if (poll(&one, 1, address == NULL ? POLL_MS : -1) > 0) {
            ssize_t length = read(in, bytes, sizeof bytes);
            if (length <= 0)
                exit(0);
            for (ssize_t i = 0; i < length; i++)
                ps_take(&ps, bytes[i]);
        }
        ps_poll(&ps, milliseconds());
        flush(out);
    }
}

/* The wire that they share: each hears whatever is said there, but for its own words. */

#define MOST 250

static struct pollfd ends[MOST + 1];

static int begin_device(const char *address, nfds_t others)
{
    int pair[2];
    pid_t child;
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, pair) != 0 || (child = fork()) < 0) {
        perror("device");
        exit(1);
    }
    if (child == 0) {
        close(pair[0]);
        for (nfds_t i = 1; i <= others; i++)
            close(ends[i].fd);
        be_device(pair[1], pair[1], address);
    }
    fprintf(stderr, "%s %d\n", address, (int)child);
    close(pair[1]);
    return pair[0];
}

static void carry(nfds_t from, nfds_t count, int out)
{
    char bytes[512];
    ssize_t length = read(ends[from].fd, bytes, sizeof bytes);
    if (length <= 0 && from == 0)
        exit(0);
    if (length <= 0)
        ends[from].fd = -1; /* a device that has died is silent */
    for (nfds_t to = 0; length > 0 && to <= count; to++) {
        if (to == 0 && from != 0 && write(out, bytes, (size_t)length) < 0)
            exit(0);
        if (to != 0 && to != from && ends[to].fd >= 0) /* who is stopped misses it */
            send(ends[to].fd, bytes, (size_t)length, MSG_NOSIGNAL | MSG_DONTWAIT);
    }
}

static void be_wire(int in, int out, int first, int last)
{
    static char addresses[MOST][12];
    nfds_t count = 0;
    for (; first <= last && count < MOST; first++, count++) {
        sprintf(addresses[count], "%d", first);
        ends[count + 1].fd = begin_device(addresses[count], count);
        ends[count + 1].events = POLLIN;
    }
    make_raw(in);
    ends[0].fd = in;
    ends[0].events = POLLIN;
    for (;;) {
        poll(ends, count + 1, -1);
        for (nfds_t i = 0; i <= count; i++)
            if (ends[i].fd >= 0 && ends[i].revents != 0)
                carry(i, count, out);
    }
}

int main(int argc, char **argv)
{
    bool is_own = argc > 1 && strcmp(argv[1], "--pty") == 0;
    int in = is_own ? own_terminal() : STDIN_FILENO, out = is_own ? in : STDOUT_FILENO;
    argc -= is_own ? 1 : 0;
    argv += is_own ? 1 : 0;
    if (argc > 2)
        be_wire(in, out, atoi(argv[1]), atoi(argv[2]));
    be_device(in, out, argc > 1 ? argv[1] : NULL);
}
