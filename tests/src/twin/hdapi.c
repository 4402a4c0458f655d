/* A stand-in for the vendor's HDAPI: the functions that the driver uses, with two virtual styli on springs behind them.
 *
 * Types and numbers are those of the public headers, version 3.0; units are HDAPI's: mm, mm/s, N, N/mm. A stylus hangs
 * on a spring from a hand that the test moves, is pushed by the force that was set, and is served 1000 times a second.
 * What goes wrong goes wrong with the device that is current.
 * Invariant: the force counts only between frames that were begun and ended, of a device that was opened and enabled. */

#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <pthread.h>
#include <string.h>
#include <time.h>

typedef struct { unsigned int code; int internal; unsigned int device; } HDErrorInfo;
typedef unsigned int (*HDSchedulerCallback)(void *);

enum { HANDLE = 7, STYLI = 2, FORCE_OUTPUT = 0x4000, ERRORS = 8 };
enum {
  PLUGGED, UNPLUGGED, NOT_A_NUMBER, FROZEN, WARM, ZERO_LIMITS, LATE, VERY_LATE, ERRORS_WITHOUT_END, ODD_ERRORS, ODD_WORKSPACE
};

struct stylus {
  int opened, enabled, in_frame, trouble, frames, buttons;
  double hand_mm[3], at_mm[3], mm_s[3], force_n[3], sent_n[3];
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_t thread;
static int runs;
static unsigned int errors[ERRORS], error_count;
static HDSchedulerCallback callback;
static void *callback_data;
static const char *const names[STYLI] = {"Default Device", "Left Device"};
static struct stylus styli[STYLI];
static struct stylus *now = styli;

/* 100 g, critically damped on 0.2 N/mm: the stylus gives way by 5 mm for a newton. */
static const double KG = 0.1, N_MM = 0.2, NS_MM = 0.00894;

static void fail(unsigned int code) {
  if (error_count < ERRORS) errors[error_count++] = code;
}

static int ready(void) {
  if (!now->opened) fail(0x0104);
  else if (now->trouble == UNPLUGGED) fail(0x0302);
  return now->opened && now->trouble != UNPLUGGED;
}

/* Makes the device of a handle the current one. */
static int is_known(unsigned int handle) {
  if (handle - HANDLE >= STYLI) { fail(0x0104); return 0; }
  now = &styli[handle - HANDLE];
  return 1;
}

static void step(struct stylus *one) {
  for (int axis = 0; axis < 3; axis++) {
    double push_n = one->sent_n[axis] + N_MM * (one->hand_mm[axis] - one->at_mm[axis]) - NS_MM * one->mm_s[axis];
    one->mm_s[axis] += push_n / KG * 1000.0 * 0.001;
    one->at_mm[axis] += one->mm_s[axis] * 0.001;
  }
}

static void *serve(void *unused) {
  (void)unused;
  for (;;) {
    pthread_mutex_lock(&lock);
    int late_ms = now->trouble == LATE ? 30 : now->trouble == VERY_LATE ? 200 : 1;
    pthread_mutex_unlock(&lock);
    struct timespec wait = {0, late_ms * 1000000L};
    nanosleep(&wait, NULL);
    pthread_mutex_lock(&lock);
    int goes_on = runs;
    HDSchedulerCallback call = now->trouble == FROZEN ? NULL : callback;
    for (int at = 0; at < STYLI; at++) step(&styli[at]);
    pthread_mutex_unlock(&lock);
    if (!goes_on) return NULL;
    if (call && call(callback_data) == 0) callback = NULL;
  }
}

unsigned int hdInitDevice(const char *name) {
  pthread_mutex_lock(&lock);
  unsigned int handle = 0xFFFFFFFFu;
  int at = 0;
  while (name && at < STYLI && strcmp(name, names[at])) at++;
  if (at == STYLI || styli[at].trouble == UNPLUGGED) fail(0x0300);
  else if (styli[at].opened) fail(0x0301);
  else {
    now = &styli[at];
    now->opened = 1;
    handle = HANDLE + at;
    memset(now->sent_n, 0, sizeof now->sent_n);
  }
  pthread_mutex_unlock(&lock);
  return handle;
}

void hdDisableDevice(unsigned int handle) {
  pthread_mutex_lock(&lock);
  if (is_known(handle)) {
    now->opened = now->enabled = 0;
    memset(now->sent_n, 0, sizeof now->sent_n);
  }
  pthread_mutex_unlock(&lock);
}

void hdEnable(unsigned int capability) {
  pthread_mutex_lock(&lock);
  if (capability != FORCE_OUTPUT) fail(0x0100);
  else if (ready()) now->enabled = 1;
  pthread_mutex_unlock(&lock);
}

unsigned long hdScheduleAsynchronous(HDSchedulerCallback call, void *data, unsigned short priority) {
  (void)priority;
  pthread_mutex_lock(&lock);
  callback = call;
  callback_data = data;
  pthread_mutex_unlock(&lock);
  return 1;
}

void hdStartScheduler(void) {
  pthread_mutex_lock(&lock);
  int starts = !runs;
  runs = 1;
  pthread_mutex_unlock(&lock);
  if (starts && pthread_create(&thread, NULL, serve, NULL)) fail(0x0304);
}

void hdStopScheduler(void) {
  pthread_mutex_lock(&lock);
  int ran = runs;
  runs = 0;
  pthread_mutex_unlock(&lock);
  if (ran) pthread_join(thread, NULL);
}

void hdUnschedule(unsigned long handle) {
  pthread_mutex_lock(&lock);
  if (handle != 1 || !callback) fail(0x0101);
  callback = NULL;
  pthread_mutex_unlock(&lock);
}

void hdBeginFrame(unsigned int handle) {
  pthread_mutex_lock(&lock);
  if (is_known(handle) && ready()) now->in_frame = 1;
  pthread_mutex_unlock(&lock);
}

void hdEndFrame(unsigned int handle) {
  pthread_mutex_lock(&lock);
  if (is_known(handle)) {
    if (!now->in_frame) fail(0x0401);
    else if (ready()) {
      if (now->trouble == WARM) { fail(0x0200); memset(now->sent_n, 0, sizeof now->sent_n); }
      else memcpy(now->sent_n, now->force_n, sizeof now->sent_n);
      now->frames++;
    }
    now->in_frame = 0;
    memset(now->force_n, 0, sizeof now->force_n);
  }
  pthread_mutex_unlock(&lock);
}

void hdGetDoublev(unsigned int what, double *values) {
  static const double reach[6] = {-80, -60, -35, 80, 60, 35};
  pthread_mutex_lock(&lock);
  if (ready()) switch (what) {
    case 0x2050: memcpy(values, now->at_mm, sizeof now->at_mm); if (now->trouble == NOT_A_NUMBER) values[1] = NAN; break;
    case 0x2051: memcpy(values, now->mm_s, sizeof now->mm_s); break;
    case 0x2551: memcpy(values, reach, sizeof reach); if (now->trouble == ODD_WORKSPACE) values[5] = -35; break;
    case 0x2602: values[0] = 0.5; break;
    case 0x2603: values[0] = now->trouble == ZERO_LIMITS ? 0.0 : 3.0; break;
    case 0x2604: values[0] = now->trouble == ZERO_LIMITS ? 0.0 : 0.8; break;
    case 0x2609: values[0] = 0.003; break;
    default: fail(0x0100);
  }
  pthread_mutex_unlock(&lock);
}

void hdGetIntegerv(unsigned int what, int *values) {
  pthread_mutex_lock(&lock);
  if (what != 0x2000) fail(0x0100);
  else if (ready()) values[0] = now->buttons;
  pthread_mutex_unlock(&lock);
}

void hdSetDoublev(unsigned int what, const double *values) {
  pthread_mutex_lock(&lock);
  if (what != 0x2700) fail(0x0100);
  else if (!now->in_frame || !now->enabled) fail(0x0102);
  else if (ready()) memcpy(now->force_n, values, sizeof now->force_n);
  pthread_mutex_unlock(&lock);
}

const char *hdGetString(unsigned int what) {
  return what == 0x2501 ? "PHANTOM Omni (twin)" : NULL;
}

HDErrorInfo hdGetError(void) {
  static unsigned int odd = 0xDEADBEEFu;
  pthread_mutex_lock(&lock);
  HDErrorInfo info = {0, 0, HANDLE + (unsigned int)(now - styli)};
  if (error_count) info.code = errors[--error_count];
  else if (now->trouble == ERRORS_WITHOUT_END) info.code = 0x0303;
  /* never 0, and never one of those that are known */
  else if (now->trouble == ODD_ERRORS) info.code = (odd = odd * 1664525u + 1013904223u) | 0x80000000u;
  pthread_mutex_unlock(&lock);
  return info;
}

/* What the test does with a stylus; not part of HDAPI. */

void twin_set(int which, int what, const double *mm, int down) {
  pthread_mutex_lock(&lock);
  struct stylus *one = &styli[which];
  one->trouble = what;
  memcpy(one->hand_mm, mm, sizeof one->hand_mm);
  one->buttons = down;
  pthread_mutex_unlock(&lock);
}

void twin_look(int which, double *at, double *sent, int *state) {
  pthread_mutex_lock(&lock);
  const struct stylus *one = &styli[which];
  memcpy(at, one->at_mm, sizeof one->at_mm);
  memcpy(sent, one->sent_n, sizeof one->sent_n);
  state[0] = one->opened;
  state[1] = one->frames;
  state[2] = runs;
  pthread_mutex_unlock(&lock);
}
