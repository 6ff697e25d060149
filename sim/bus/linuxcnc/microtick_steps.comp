component microtick_steps "Step generator: LinuxCNC's joints on the registers of motion_front_end";
description """
In each servo period the component reads the counters POSITION and writes one line in all axes, which takes the steps
of the period at an even pace. Registers: docs/motion_regmap.md. Two functions reach the host port; here they go
through pipes to the simulated front-end (sim/bus/linuxcnc/steps.py), on hardware they are loads and stores.
""";
pin in float position-cmd-#[5] "commanded position";
pin out float position-fb-#[5] "steps that were sent, by scale";
pin in bit enable "the axes may move";
pin out bit enabled "the front-end answers and has no fault";
pin out bit fault "PATH_STATUS has a fault, or the front-end does not answer";
pin in bit estop-ok "LinuxCNC is not in emergency stop";
pin out bit ok "LinuxCNC may leave its emergency stop";
pin out u32 periods "servo periods so far";
pin out u32 lost "servo periods in which no line could be written";
param rw float scale-#[5] = 1000.0 "steps per unit";
function _;
license "Apache-2.0";
include <unistd.h>;
include <fcntl.h>;
include <errno.h>;
include <math.h>;
include "motion_regmap.h";
;;
#define AXES 5
#define PERIOD_CLOCKS 100000u /* 1 ms at 100 MHz */
#define LEAST_PERIOD 4u
#define LINE_IN_ALL_AXES 2u
#define PATH_FAULTS 0x7F00u /* of PATH_STATUS */
enum kind { READ, WRITE, PERIOD };

struct access {
    unsigned kind, address, data;
};

static int to_port = -1, from_port = -1;
static int opened, dead, faulty;
static struct access queue[16];
static unsigned queued;
static long long sent[AXES], counted[AXES]; /* steps */

static int whole(ssize_t (*transfer)(int, void *, size_t), int fd, void *data, size_t n) {
    char *at = data;
    while (n) {
        ssize_t done = transfer(fd, at, n);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) return 0;
        at += done;
        n -= done;
    }
    return 1;
}

static ssize_t put(int fd, void *data, size_t n) { return write(fd, data, n); }

static void port(unsigned kind, unsigned address, unsigned data) {
    queue[queued++] = (struct access){kind, address, data};
}

/* The accesses so far, in their order; the words read are in their data then. */
static void transfer(void) {
    unsigned n = queued;
    queued = 0;
    if (!dead) dead = !whole(put, to_port, &n, sizeof n) || !whole(put, to_port, queue, n * sizeof *queue) ||
                      !whole(read, from_port, queue, n * sizeof *queue);
}

FUNCTION(_) {
    unsigned longest = 0, status;
    long long goal[AXES];
    int i;
    if (!opened) {
        opened = 1;
        to_port = open("to_master", O_WRONLY);
        from_port = open("from_master", O_RDONLY);
        port(WRITE, MOTION_REG_SOURCE, (1u << AXES) - 1);
    }
    for (i = 0; i < AXES; i++) port(READ, MOTION_REG_POSITION + i, 0);
    port(READ, MOTION_REG_PATH_STATUS, 0);
    i = queued - AXES - 1;
    transfer();
    if (dead) {
        if (!fault) rtapi_print_msg(RTAPI_MSG_ERR, "microtick_steps: the front-end does not answer");
        fault = 1;
        ok = enabled = 0;
        lost = lost + 1;
        return;
    }
    status = queue[i + AXES].data;
    {
        struct access *read_words = queue + i;
        for (i = 0; i < AXES; i++) {
            counted[i] += (int)(read_words[i].data - (unsigned)counted[i]);
            position_fb(i) = counted[i] / scale(i);
        }
    }
    if ((status & PATH_FAULTS) && !faulty) {
        rtapi_print_msg(RTAPI_MSG_ERR, "microtick_steps: fault of the front-end, PATH_STATUS %04X", status);
    }
    faulty = (status & PATH_FAULTS) != 0;
    for (i = 0; i < AXES; i++) {
        long long steps;
        goal[i] = enable && !faulty ? llround(position_cmd(i) * scale(i)) : sent[i];
        steps = goal[i] > sent[i] ? goal[i] - sent[i] : sent[i] - goal[i];
        if (steps > longest) longest = steps > PERIOD_CLOCKS ? PERIOD_CLOCKS : (unsigned)steps;
    }
    if (longest && (status & 1u)) {
        lost = lost + 1; /* the line before still waits: its steps come with the next one */
    } else if (longest) {
        unsigned period = PERIOD_CLOCKS / (longest + 1);
        for (i = 0; i < AXES; i++) {
            port(WRITE, MOTION_REG_PATH_WORD + i, (unsigned)(goal[i] - sent[i]));
            sent[i] = goal[i];
        }
        port(WRITE, MOTION_REG_PATH_FEED, period < LEAST_PERIOD ? LEAST_PERIOD : period);
        port(WRITE, MOTION_REG_PATH_COMMAND, LINE_IN_ALL_AXES);
    }
    port(PERIOD, 0, 0);
    transfer();
    periods = periods + 1;
    fault = faulty;
    enabled = enable && !faulty;
    ok = estop_ok && !faulty;
}
