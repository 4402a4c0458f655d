/* A stand-in for the gamepads in /dev/input, loaded before the C library into a program that reads them.
 *
 * Numbers and structures are those of the kernel's public headers. What the program opens as /dev/input/eventN is one end
 * of a pair of sockets, through which it reads events in the kernel's form; what it asks by ioctl is answered here, and what
 * it writes to the motors is kept. The names of the pads are the texts of the files eventN in the folder EVDEV_TWIN.
 * Invariant: every opening of a pad gets every event, and none after the pad was pulled out. */

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/input.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PADS = 4, OPENINGS = 256, EFFECT = 3 };

struct pad {
  int is_known, is_out, has_motors, is_read_only;
  unsigned char keys[KEY_MAX / 8 + 1], down[KEY_MAX / 8 + 1], axes[ABS_MAX / 8 + 1];
  struct input_absinfo at[ABS_MAX + 1];
  /* the effect as it was uploaded last, how often, whether it plays, and whether it was taken away */
  struct ff_effect effect;
  int uploads, plays, is_erased;
};

struct opening { struct pad *pad; ino_t inode; int end, is_dead; };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct pad pads[PADS];
static struct opening openings[OPENINGS];

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static void set(unsigned char *bits, unsigned at, int on) {
  if (on) bits[at / 8] |= 1u << at % 8;
  else bits[at / 8] &= ~(1u << at % 8);
}

static void add_axis(struct pad *pad, int code, int value, int least, int most, int flat) {
  set(pad->axes, code, 1);
  pad->at[code] = (struct input_absinfo){.value = value, .minimum = least, .maximum = most, .flat = flat};
}

/* The pad of that number; at first with the sticks, triggers and motors that the kernel's own drivers show. */
static struct pad *pad_of(int number) {
  if (number < 0 || number >= PADS) return NULL;
  struct pad *pad = &pads[number];
  if (!pad->is_known) {
    pad->is_known = pad->has_motors = 1;
    for (int code = ABS_X; code <= ABS_RZ; code++) {
      int is_trigger = code == ABS_Z || code == ABS_RZ;
      if (is_trigger) add_axis(pad, code, 0, 0, 255, 0);
      else add_axis(pad, code, 0, -32768, 32767, 128);
    }
    for (int code = BTN_SOUTH; code <= BTN_THUMBR; code++) set(pad->keys, code, 1);
  }
  return pad;
}

/* The opening behind a descriptor or a copy of it. */
static struct opening *opening_of(int fd) {
  struct stat status;
  if (fstat(fd, &status) || !S_ISSOCK(status.st_mode)) return NULL;
  for (int at = 0; at < OPENINGS; at++)
    if (openings[at].pad && openings[at].inode == status.st_ino) return &openings[at];
  return NULL;
}

/* The number of a pad by its path, or -1. */
static int number_of(const char *path) {
  int number = -1;
  return path && sscanf(path, "/dev/input/event%d", &number) == 1 ? number : -1;
}

static int fail(int code) { errno = code; return -1; }

/* Takes back the places of openings that the program has closed. */
static void sweep(void) {
  char byte;
  for (int at = 0; at < OPENINGS; at++) {
    struct opening *opening = &openings[at];
    if (!opening->pad || opening->is_dead || recv(opening->end, &byte, 1, MSG_PEEK | MSG_DONTWAIT)) continue;
    close(opening->end);
    opening->pad = NULL;
  }
}

static int open_pad(int number, int flags) {
  struct pad *pad = pad_of(number);
  if (!pad) return fail(ENOENT);
  if (pad->is_out) return fail(ENODEV);
  if (pad->is_read_only && (flags & O_ACCMODE) != O_RDONLY) return fail(EACCES);
  sweep();
  for (int at = 0; at < OPENINGS; at++) {
    struct stat status;
    int ends[2];
    if (openings[at].pad) continue;
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) || fstat(ends[0], &status)) return -1;
    openings[at] = (struct opening){.pad = pad, .inode = status.st_ino, .end = ends[1]};
    return ends[0];
  }
  return fail(EMFILE);
}

int open64(const char *path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  int mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, int) : 0;
  va_end(rest);
  int number = number_of(path);
  if (number < 0) return REAL(open64)(path, flags, mode);
  pthread_mutex_lock(&lock);
  int fd = open_pad(number, flags);
  pthread_mutex_unlock(&lock);
  return fd;
}

int open(const char *path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  int mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, int) : 0;
  va_end(rest);
  return open64(path, flags, mode);
}

DIR *opendir(const char *path) {
  const char *folder = getenv("EVDEV_TWIN");
  return REAL(opendir)(folder && !strcmp(path, "/dev/input") ? folder : path);
}

ssize_t read(int fd, void *into, size_t count) {
  pthread_mutex_lock(&lock);
  struct opening *opening = opening_of(fd);
  int is_dead = opening && opening->is_dead;
  pthread_mutex_unlock(&lock);
  return is_dead ? fail(ENODEV) : REAL(read)(fd, into, count);
}

/* What a program writes to a pad: effects to be played. */
static ssize_t take(struct opening *opening, const void *from, size_t count) {
  if (opening->is_dead) return fail(ENODEV);
  if (opening->pad->is_read_only) return fail(EBADF);
  const struct input_event *events = from;
  for (size_t at = 0; at < count / sizeof *events; at++)
    if (events[at].type == EV_FF && events[at].code == EFFECT) opening->pad->plays = events[at].value;
  return count;
}

ssize_t write(int fd, const void *from, size_t count) {
  pthread_mutex_lock(&lock);
  struct opening *opening = opening_of(fd);
  ssize_t taken = opening ? take(opening, from, count) : 0;
  pthread_mutex_unlock(&lock);
  return opening ? taken : REAL(write)(fd, from, count);
}

static int give(void *to, size_t room, const void *from, size_t size) {
  size_t count = size < room ? size : room;
  memset(to, 0, room);
  memcpy(to, from, count);
  return count;
}

/* The bits of a kind of event: which kinds there are for kind 0. */
static int bits(struct pad *pad, int kind, void *to, size_t room) {
  unsigned char all[FF_MAX / 8 + 1] = {0};
  if (kind == 0) {
    set(all, EV_SYN, 1), set(all, EV_KEY, 1), set(all, EV_ABS, 1), set(all, EV_FF, pad->has_motors);
    return give(to, room, all, sizeof all);
  }
  if (kind == EV_KEY) return give(to, room, pad->keys, sizeof pad->keys);
  if (kind == EV_ABS) return give(to, room, pad->axes, sizeof pad->axes);
  if (kind == EV_FF) set(all, FF_RUMBLE, pad->has_motors);
  return give(to, room, all, sizeof all);
}

static int name(struct pad *pad, char *to, size_t room) {
  char path[4096], text[256] = "";
  snprintf(path, sizeof path, "%s/event%d", getenv("EVDEV_TWIN"), (int)(pad - pads));
  FILE *file = fopen(path, "r");
  if (file) {
    if (!fgets(text, sizeof text, file)) text[0] = 0;
    fclose(file);
  }
  return give(to, room, text, strlen(text) + 1);
}

static int upload(struct pad *pad, struct ff_effect *effect) {
  if (pad->is_read_only) return fail(EBADF);
  if (!pad->has_motors) return fail(ENOSYS);
  if (effect->id == -1) effect->id = EFFECT;
  if (effect->id != EFFECT) return fail(EINVAL);
  pad->effect = *effect;
  pad->uploads++;
  pad->is_erased = 0;
  return 0;
}

static int answer(struct opening *opening, unsigned long request, void *argument) {
  struct pad *pad = opening->pad;
  size_t room = _IOC_SIZE(request);
  unsigned number = _IOC_NR(request);
  if (opening->is_dead) return fail(ENODEV);
  if (number >= 0x40 && number < 0x40 + ABS_CNT) return give(argument, room, &pad->at[number - 0x40], sizeof pad->at[0]), 0;
  if (number >= 0x20 && number < 0x40) return bits(pad, number - 0x20, argument, room);
  switch (number) {
    case 0x01: *(int *)argument = EV_VERSION; return 0;
    case 0x02: memset(argument, 0, room); return 0;
    case 0x06: return name(pad, argument, room);
    case 0x09: memset(argument, 0, room); return room;
    case 0x18: return give(argument, room, pad->down, sizeof pad->down);
    case 0x80: return upload(pad, argument);
    case 0x81: pad->is_erased = 1; pad->plays = 0; return 0;
    case 0x84: *(int *)argument = 16; return 0;
    default: return fail(ENOENT);
  }
}

int ioctl(int fd, unsigned long request, ...) {
  va_list rest;
  va_start(rest, request);
  void *argument = va_arg(rest, void *);
  va_end(rest);
  if (_IOC_TYPE(request) != 'E') return REAL(ioctl)(fd, request, argument);
  pthread_mutex_lock(&lock);
  struct opening *opening = opening_of(fd);
  int answered = opening ? answer(opening, request, argument) : 0;
  pthread_mutex_unlock(&lock);
  return opening ? answered : REAL(ioctl)(fd, request, argument);
}

/* What the test does with a pad; not part of the kernel. */

void twin_axis(int number, int code, const int *at) {
  pthread_mutex_lock(&lock);
  struct pad *pad = pad_of(number);
  if (at) add_axis(pad, code, at[0], at[1], at[2], at[3]);
  else set(pad->axes, code, 0);
  pthread_mutex_unlock(&lock);
}

/* Out or in again, with motors or without, for reading alone or not. */
void twin_pad(int number, int is_out, int has_motors, int is_read_only) {
  pthread_mutex_lock(&lock);
  struct pad *pad = pad_of(number);
  pad->is_out = is_out, pad->has_motors = has_motors, pad->is_read_only = is_read_only;
  for (int at = 0; at < OPENINGS; at++)
    if (openings[at].pad == pad && is_out && !openings[at].is_dead) {
      openings[at].is_dead = 1;
      close(openings[at].end);
    }
  pthread_mutex_unlock(&lock);
}

/* Something moves; the program hears of it, unless it is lost. */
void twin_event(int number, int type, int code, int value, int is_lost) {
  struct input_event event = {.type = type, .code = code, .value = value};
  pthread_mutex_lock(&lock);
  struct pad *pad = pad_of(number);
  if (type == EV_ABS) pad->at[code].value = value;
  if (type == EV_KEY) set(pad->down, code, value);
  for (int at = 0; at < OPENINGS && !is_lost; at++) {
    struct opening *opening = &openings[at];
    if (opening->pad != pad || opening->is_dead) continue;
    if (send(opening->end, &event, sizeof event, MSG_NOSIGNAL | MSG_DONTWAIT) < 0 && errno != EPIPE) abort();
  }
  pthread_mutex_unlock(&lock);
}

/* Heavy and light motor as they were uploaded last, their length, whether they play, uploads, and whether all was taken away. */
void twin_motors(int number, int *to) {
  pthread_mutex_lock(&lock);
  struct pad *pad = pad_of(number);
  to[0] = pad->effect.u.rumble.strong_magnitude;
  to[1] = pad->effect.u.rumble.weak_magnitude;
  to[2] = pad->effect.replay.length;
  to[3] = pad->plays;
  to[4] = pad->uploads;
  to[5] = pad->is_erased;
  pthread_mutex_unlock(&lock);
}
