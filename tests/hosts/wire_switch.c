/* A switch between network namespaces, as a program: a kernel's netem is not everywhere.
 *
 *   wire_switch ports SEED NAME...   joins the interfaces of these names, until standard input ends
 *   wire_switch plain NAME           switches off what an interface leaves to hardware, and ends
 *
 * Hosts have the addresses 02:00:00:00:00:PORT, with 1 for the first name: nothing has to be learnt.
 *
 * Each line of standard input is a command, answered by "ok" or "bad":
 *
 *   PORT in|out DELAY_US JITTER_US LOSS_PPM   for frames that come from the host (in), or go to it (out)
 *   PORT network NUMBER                       frames go to ports of the same network alone; 0 is cut off
 *
 * Frames from one port to another keep their order, whatever the jitter: TCP takes others for losses.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <linux/ethtool.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <arpa/inet.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { MOST_PORTS = 16, MOST_WAITING = 32768, LONGEST_FRAME = 1600, AT_ONCE = 64 };
enum { IN, OUT, WAYS };

static const uint8_t OUR_PREFIX[5] = {2, 0, 0, 0, 0};

typedef struct {
    int64_t delay_ns, jitter_ns;
    uint32_t loss_ppm;
} way_state;

typedef struct {
    int fd, network;
    way_state ways[WAYS];
    int64_t last_due_ns[MOST_PORTS]; /* of frames to each other port */
} port_state;

typedef struct {
    int64_t due_ns;
    uint64_t number;
    int to, length;
    uint8_t bytes[LONGEST_FRAME];
} frame_state;

static port_state ports[MOST_PORTS];
static int n_ports;
static frame_state frames[MOST_WAITING];
static int waiting[MOST_WAITING]; /* a heap: of each three the first is due first; behind it free frames */
static int n_waiting;
static uint64_t frame_number, random_state;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

/* xorshift64*: Vigna, "An experimental exploration of Marsaglia's xorshift generators, scrambled" (2016). */
static uint32_t draw(uint32_t below)
{
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return (uint32_t)((random_state * 0x2545F4914F6CDD1DULL >> 32) % below);
}

static int is_before(int a, int b)
{
    const frame_state *x = &frames[waiting[a]], *y = &frames[waiting[b]];
    return x->due_ns < y->due_ns || (x->due_ns == y->due_ns && x->number < y->number);
}

static void swap(int a, int b)
{
    int kept = waiting[a];
    waiting[a] = waiting[b];
    waiting[b] = kept;
}

static void sift_up(int at)
{
    for (int above; at > 0 && is_before(at, above = (at - 1) / 2); at = above) swap(at, above);
}

static void sift_down(int at)
{
    for (;;) {
        int first = at;
        for (int below = 2 * at + 1; below <= 2 * at + 2; below++)
            if (below < n_waiting && is_before(below, first)) first = below;
        if (first == at) return;
        swap(at, first);
        at = first;
    }
}

static int64_t delay_of(const way_state *way)
{
    if (!way->jitter_ns) return way->delay_ns;
    int64_t us = way->jitter_ns / 1000;
    return way->delay_ns + (draw((uint32_t)(2 * us + 1)) - us) * 1000;
}

static int is_lost(const way_state *way)
{
    return way->loss_ppm && draw(1000000) < way->loss_ppm;
}

static void queue(int from, int to, const uint8_t *bytes, int length)
{
    port_state *source = &ports[from];
    const way_state *in = &source->ways[IN], *out = &ports[to].ways[OUT];
    if (!source->network || source->network != ports[to].network) return;
    if (is_lost(in) || is_lost(out)) return;
    if (n_waiting == MOST_WAITING) return; /* as a switch whose buffer is full */
    int64_t due_ns = now_ns() + delay_of(in) + delay_of(out);
    if (due_ns < source->last_due_ns[to]) due_ns = source->last_due_ns[to];
    source->last_due_ns[to] = due_ns;
    frame_state *frame = &frames[waiting[n_waiting]];
    frame->due_ns = due_ns;
    frame->number = frame_number++;
    frame->to = to;
    frame->length = length;
    memcpy(frame->bytes, bytes, (size_t)length);
    sift_up(n_waiting++);
}

static void receive(int from)
{
    for (int n = 0; n < AT_ONCE; n++) {
        uint8_t bytes[LONGEST_FRAME];
        ssize_t length = recv(ports[from].fd, bytes, sizeof bytes, MSG_DONTWAIT | MSG_TRUNC);
        if (length < 0) return;
        if (length < ETH_HLEN || length > LONGEST_FRAME) continue;
        int only = memcmp(bytes, OUR_PREFIX, sizeof OUR_PREFIX) ? -1 : bytes[5] - 1;
        for (int to = 0; to < n_ports; to++)
            if (to != from && (only < 0 || to == only)) queue(from, to, bytes, (int)length);
    }
}

static void send_due(void)
{
    while (n_waiting && frames[waiting[0]].due_ns <= now_ns()) {
        const frame_state *frame = &frames[waiting[0]];
        /* What the other end does not take is lost, as on a wire. */
        ssize_t sent = send(ports[frame->to].fd, frame->bytes, (size_t)frame->length, MSG_DONTWAIT);
        (void)sent;
        swap(0, --n_waiting);
        sift_down(0);
    }
}

static int obey(const char *line)
{
    int port, network;
    char which[8];
    long long delay_us, jitter_us;
    unsigned loss_ppm;
    if (sscanf(line, "%d network %d", &port, &network) == 2 && port >= 1 && port <= n_ports) {
        ports[port - 1].network = network;
        return 1;
    }
    if (sscanf(line, "%d %7s %lld %lld %u", &port, which, &delay_us, &jitter_us, &loss_ppm) != 5) return 0;
    if (port < 1 || port > n_ports || jitter_us < 0 || delay_us < jitter_us || jitter_us > 1000000) return 0;
    way_state way = {.delay_ns = delay_us * 1000, .jitter_ns = jitter_us * 1000, .loss_ppm = loss_ppm};
    if (!strcmp(which, "in"))
        ports[port - 1].ways[IN] = way;
    else if (!strcmp(which, "out"))
        ports[port - 1].ways[OUT] = way;
    else
        return 0;
    return 1;
}

/* Obeys whole lines; 0 once the input has ended. */
static int read_commands(void)
{
    static char text[4096];
    static size_t length;
    ssize_t got = read(STDIN_FILENO, text + length, sizeof text - 1 - length);
    if (got <= 0) return 0;
    length += (size_t)got;
    text[length] = 0;
    for (char *end; (end = strchr(text, '\n'));) {
        *end++ = 0;
        puts(obey(text) ? "ok" : "bad");
        length -= (size_t)(end - text);
        memmove(text, end, length + 1);
    }
    fflush(stdout);
    return length < sizeof text - 1;
}

static int opened(const char *name)
{
    int fd = socket(AF_PACKET, SOCK_RAW, htons(ETH_P_ALL)), room = 8 << 20, yes = 1;
    struct sockaddr_ll at = {.sll_family = AF_PACKET, .sll_protocol = htons(ETH_P_ALL)};
    at.sll_ifindex = (int)if_nametoindex(name);
    if (fd < 0 || !at.sll_ifindex || setsockopt(fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &yes, sizeof yes) ||
        bind(fd, (struct sockaddr *)&at, sizeof at)) {
        perror(name);
        exit(1);
    }
    setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room);
    setsockopt(fd, SOL_SOCKET, SO_SNDBUFFORCE, &room, sizeof room);
    return fd;
}

static int join(int n, char **names)
{
    struct pollfd polled[MOST_PORTS + 1];
    if (n < 2 || n > MOST_PORTS) return 2;
    n_ports = n;
    for (int i = 0; i < MOST_WAITING; i++) waiting[i] = i;
    for (int i = 0; i < n; i++) {
        ports[i].fd = opened(names[i]);
        ports[i].network = 1;
        polled[i] = (struct pollfd){.fd = ports[i].fd, .events = POLLIN};
    }
    polled[n] = (struct pollfd){.fd = STDIN_FILENO, .events = POLLIN};
    puts("ready");
    fflush(stdout);
    for (;;) {
        int64_t left_ns = n_waiting ? frames[waiting[0]].due_ns - now_ns() : 0;
        if (left_ns < 0) left_ns = 0;
        struct timespec left = {.tv_sec = left_ns / 1000000000, .tv_nsec = left_ns % 1000000000};
        if (ppoll(polled, (nfds_t)n + 1, n_waiting ? &left : NULL, NULL) < 0 && errno != EINTR) return 1;
        send_due();
        for (int i = 0; i < n; i++)
            if (polled[i].revents) receive(i);
        if (polled[n].revents && !read_commands()) return 0;
    }
}

/* Segments and check sums are made by the host: a frame of 64 kB would fit through no port here. */
static int make_plain(const char *name)
{
    static const uint32_t commands[] = {ETHTOOL_STXCSUM, ETHTOOL_STSO, ETHTOOL_SGSO, ETHTOOL_SGRO};
    int fd = socket(AF_INET, SOCK_DGRAM, 0);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        struct ethtool_value off = {.cmd = commands[i], .data = 0};
        struct ifreq request = {.ifr_data = (char *)&off};
        snprintf(request.ifr_name, sizeof request.ifr_name, "%s", name);
        if (ioctl(fd, SIOCETHTOOL, &request) && errno != EOPNOTSUPP) {
            perror(name);
            return 1;
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 3 && !strcmp(argv[1], "plain")) return make_plain(argv[2]);
    if (argc < 4 || strcmp(argv[1], "ports")) return 2;
    random_state = strtoull(argv[2], NULL, 10) * 2 + 1; /* never 0 */
    return join(argc - 3, argv + 3);
}
