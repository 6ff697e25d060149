component microtick_bus "Hands the servo thread's targets to the master of the bus, and waits for its answer";
description """
One exchange in each servo period, through two pipes in LinuxCNC's folder. The thread waits for the answer, so
LinuxCNC advances one period for each period of the simulated machine, however slow the simulation is. The layout of
both messages is in sim/bus/linuxcnc/link.py.
""";
pin in float target-#[5] "commanded position, mm or degrees";
pin out float position-#[5] "measured position, mm or degrees";
pin in bit enable-#[5] "the drive is to be in operation enabled";
pin out bit fault-#[5] "the drive has a fault, left operation enabled by itself, or does not answer";
pin out u32 error-#[5] "error code of the drive, object 603F";
pin in bit estop-ok "false: quick stop";
pin in bit home "rising edge: the drives home, method 37";
pin out bit homed "all drives are homed";
pin out bit enabled "all drives are in operation enabled";
pin out bit ok "LinuxCNC may leave its emergency stop: estop-ok, and the bus answers";
pin out u32 periods "exchanges so far";
pin out u32 lost "servo periods without process data from the drives";
function _;
license "Apache-2.0";
include <unistd.h>;
include <fcntl.h>;
include <errno.h>;
;;
#define AXES 5
#define LINK 1u
#define ENABLED 2u
#define HOMED 4u
#define ESTOP_OK 0x100u
#define HOME 0x200u

struct request {
    unsigned number, flags; /* bit n: enable of axis n; ESTOP_OK, HOME */
    double wanted[AXES];
};

struct answer {
    unsigned number, flags, missed, faulty; /* bit n of faulty: axis n */
    unsigned code[AXES], reserved;
    double place[AXES];
};

static int to_master = -1, from_master = -1;
static int opened, was_linked, was_silent;
static unsigned were_faulty;
static const char axis_name[] = "XYZAC";

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

static const char *cause(unsigned code) {
    switch (code) {
        case 0x5441: return "disabled by the machine";
        case 0x7500: return "communication with the master was lost";
        case 0x8611: return "following error";
        case 0: return "it left operation enabled";
        default: return "see object 603F";
    }
}

FUNCTION(_) {
    struct request request = {0};
    struct answer answer = {0};
    int i, silent;
    if (!opened) {
        opened = 1;
        to_master = open("to_master", O_WRONLY);
        from_master = open("from_master", O_RDONLY);
    }
    request.number = periods + 1;
    for (i = 0; i < AXES; i++) {
        request.flags |= (unsigned)(enable(i) != 0) << i;
        request.wanted[i] = target(i);
    }
    if (estop_ok) request.flags |= ESTOP_OK;
    if (home) request.flags |= HOME;
    if (to_master >= 0 && (!whole(put, to_master, &request, sizeof request) ||
                           !whole(read, from_master, &answer, sizeof answer))) {
        close(to_master);
        close(from_master);
        to_master = from_master = -1;
        rtapi_print_msg(RTAPI_MSG_ERR, "microtick_bus: the master of the bus is gone");
    }
    if (to_master < 0) { /* positions stay, the drives stop by themselves */
        ok = enabled = 0;
        lost = lost + 1;
        for (i = 0; i < AXES; i++) fault(i) = 1;
        return;
    }
    if (answer.number != request.number) answer.flags &= ~LINK;
    periods = answer.number;
    lost = answer.missed;
    silent = was_linked && !(answer.flags & LINK);
    if (silent && !was_silent) {
        rtapi_print_msg(RTAPI_MSG_ERR, "microtick_bus: the drives do not answer, %u servo periods are lost",
                        answer.missed);
    }
    was_silent = silent;
    was_linked |= (answer.flags & LINK) != 0;
    for (i = 0; i < AXES; i++) {
        unsigned bit = 1u << i;
        position(i) = answer.place[i];
        fault(i) = (answer.faulty & bit) != 0 || silent;
        error(i) = answer.code[i];
        if (answer.faulty & ~were_faulty & bit) {
            rtapi_print_msg(RTAPI_MSG_ERR, "microtick_bus: drive of axis %c: error %04X, %s", axis_name[i],
                            answer.code[i], cause(answer.code[i]));
        }
    }
    were_faulty = answer.faulty;
    homed = (answer.flags & HOMED) != 0;
    enabled = (answer.flags & ENABLED) != 0;
    ok = estop_ok && was_linked && !silent;
}
