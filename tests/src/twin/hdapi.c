/* A stand-in for the vendor's HDAPI: the functions that the driver uses, with a virtual stylus on a spring behind them.
 *
 * Types and numbers are those of the public headers, version 3.0; units are HDAPI's: mm, mm/s, N, N/mm. The stylus hangs
 * on a spring from a hand that the test moves, is pushed by the force that was set, and is served 1000 times a second.
 * Invariant: the force counts only between frames that were begun and ended, of a device that was opened and enabled. */

#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <pthread.h>
#include <string.h>
#include <time.h>

typedef struct { unsigned int code; int internal; unsigned int device; } HDErrorInfo;
typedef unsigned int (*HDSchedulerCallback)(void *);

enum { HANDLE = 7, FORCE_OUTPUT = 0x4000, ERRORS = 8 };
enum { PLUGGED, UNPLUGGED, NOT_A_NUMBER, FROZEN, WARM, ZERO_LIMITS };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_t thread;
static int runs, opened, enabled, in_frame, trouble, frames;
static unsigned int errors[ERRORS], error_count;
static HDSchedulerCallback callback;
static void *callback_data;
static double hand_mm[3], at_mm[3], mm_s[3], force_n[3], sent_n[3];
static int buttons;

/* 100 g, critically damped on 0.2 N/mm: the stylus gives way by 5 mm for a newton. */
static const double KG = 0.1, N_MM = 0.2, NS_MM = 0.00894;

static void fail(unsigned int code) {
  if (error_count < ERRORS) errors[error_count++] = code;
}

static int ready(void) {
  if (!opened) fail(0x0104);
  else if (trouble == UNPLUGGED) fail(0x0302);
  return opened && trouble != UNPLUGGED;
}

static void step(void) {
  for (int axis = 0; axis < 3; axis++) {
    double push_n = sent_n[axis] + N_MM * (hand_mm[axis] - at_mm[axis]) - NS_MM * mm_s[axis];
    mm_s[axis] += push_n / KG * 1000.0 * 0.001;
    at_mm[axis] += mm_s[axis] * 0.001;
  }
}

static void *serve(void *unused) {
  (void)unused;
  struct timespec millisecond = {0, 1000000};
  for (;;) {
    nanosleep(&millisecond, NULL);
    pthread_mutex_lock(&lock);
    int goes_on = runs;
    HDSchedulerCallback call = trouble == FROZEN ? NULL : callback;
    step();
    pthread_mutex_unlock(&lock);
    if (!goes_on) return NULL;
    if (call && call(callback_data) == 0) callback = NULL;
  }
}

unsigned int hdInitDevice(const char *name) {
  pthread_mutex_lock(&lock);
  unsigned int handle = 0xFFFFFFFFu;
  if (trouble == UNPLUGGED || (name && strcmp(name, "Default Device") && strcmp(name, "Left Device"))) fail(0x0300);
  else if (opened) fail(0x0301);
  else { opened = 1; handle = HANDLE; memset(sent_n, 0, sizeof sent_n); }
  pthread_mutex_unlock(&lock);
  return handle;
}

void hdDisableDevice(unsigned int handle) {
  pthread_mutex_lock(&lock);
  if (handle != HANDLE) fail(0x0104);
  opened = enabled = 0;
  memset(sent_n, 0, sizeof sent_n);
  pthread_mutex_unlock(&lock);
}

void hdEnable(unsigned int capability) {
  pthread_mutex_lock(&lock);
  if (capability != FORCE_OUTPUT) fail(0x0100);
  else if (ready()) enabled = 1;
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
  if (handle != HANDLE) fail(0x0104);
  else if (ready()) in_frame = 1;
  pthread_mutex_unlock(&lock);
}

void hdEndFrame(unsigned int handle) {
  pthread_mutex_lock(&lock);
  if (handle != HANDLE) fail(0x0104);
  else if (!in_frame) fail(0x0401);
  else if (ready()) {
    if (trouble == WARM) { fail(0x0200); memset(sent_n, 0, sizeof sent_n); }
    else memcpy(sent_n, force_n, sizeof sent_n);
    frames++;
  }
  in_frame = 0;
  memset(force_n, 0, sizeof force_n);
  pthread_mutex_unlock(&lock);
}

void hdGetDoublev(unsigned int what, double *values) {
  pthread_mutex_lock(&lock);
  if (ready()) switch (what) {
    case 0x2050: memcpy(values, at_mm, sizeof at_mm); if (trouble == NOT_A_NUMBER) values[1] = NAN; break;
    case 0x2051: memcpy(values, mm_s, sizeof mm_s); break;
    case 0x2602: values[0] = 0.5; break;
    case 0x2603: values[0] = trouble == ZERO_LIMITS ? 0.0 : 3.0; break;
    case 0x2604: values[0] = trouble == ZERO_LIMITS ? 0.0 : 0.8; break;
    case 0x2609: values[0] = 0.003; break;
    default: fail(0x0100);
  }
  pthread_mutex_unlock(&lock);
}

void hdGetIntegerv(unsigned int what, int *values) {
  pthread_mutex_lock(&lock);
  if (what != 0x2000) fail(0x0100);
  else if (ready()) values[0] = buttons;
  pthread_mutex_unlock(&lock);
}

void hdSetDoublev(unsigned int what, const double *values) {
  pthread_mutex_lock(&lock);
  if (what != 0x2700) fail(0x0100);
  else if (!in_frame || !enabled) fail(0x0102);
  else if (ready()) memcpy(force_n, values, sizeof force_n);
  pthread_mutex_unlock(&lock);
}

const char *hdGetString(unsigned int what) {
  return what == 0x2501 ? "PHANTOM Omni (twin)" : NULL;
}

HDErrorInfo hdGetError(void) {
  pthread_mutex_lock(&lock);
  HDErrorInfo info = {0, 0, HANDLE};
  if (error_count) info.code = errors[--error_count];
  pthread_mutex_unlock(&lock);
  return info;
}

/* What the test does with the stylus; not part of HDAPI. */

void twin_set(int what, const double *mm, int down) {
  pthread_mutex_lock(&lock);
  trouble = what;
  memcpy(hand_mm, mm, sizeof hand_mm);
  buttons = down;
  pthread_mutex_unlock(&lock);
}

void twin_look(double *at, double *sent, int *state) {
  pthread_mutex_lock(&lock);
  memcpy(at, at_mm, sizeof at_mm);
  memcpy(sent, sent_n, sizeof sent_n);
  state[0] = opened;
  state[1] = frames;
  state[2] = runs;
  pthread_mutex_unlock(&lock);
}
