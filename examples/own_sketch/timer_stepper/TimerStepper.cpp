#include "TimerStepper.h"

#include <util/atomic.h>

static const float TICKS_Hz = F_CPU / 8;
static const float MOST_TICKS = 65535;  // OCR1A
static TimerStepper *running;

ISR(TIMER1_COMPA_vect) { running->onCompare(); }

TimerStepper::TimerStepper(byte stepPin, byte dirPin) : stepPin_(stepPin), dirPin_(dirPin) {
  setAcceleration(2000);
  setMaxSpeed(1000);
}

void TimerStepper::begin() {
  running = this;
  pinMode(stepPin_, OUTPUT);
  pinMode(dirPin_, OUTPUT);
  TCCR1A = 0;
  TCCR1B = 0;  // stands until there is somewhere to go
  TIFR1 = _BV(OCF1A);  // Arduino's core has had it count: without this the interrupt would come at once, with a step
  TIMSK1 = _BV(OCIE1A);
}

void TimerStepper::setAcceleration(float stepsPerS2) {
  first_ = 256 * min(0.676f * TICKS_Hz * sqrt(2 / stepsPerS2), MOST_TICKS);
}

void TimerStepper::setMaxSpeed(float stepsPerS) { least_ = 256 * min(TICKS_Hz / stepsPerS, MOST_TICKS); }

void TimerStepper::moveTo(long target) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    target_ = target;
    if (!isMoving_ && target != at_) {
      isMoving_ = true;
      restart(target - at_);
      OCR1A = 1000;  // the first step comes in 0.5 ms: longer than the interrupt takes, which would else miss a compare
      TCNT1 = 0;
      TIFR1 = _BV(OCF1A);
      TCCR1B = _BV(WGM12) | _BV(CS11);  // clear on compare, 16 MHz / 8
    }
  }
}

long TimerStepper::position() const {
  long at = 0;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { at = at_; }
  return at;
}

float TimerStepper::speed() const {
  unsigned long interval = 0;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { interval = isMoving_ ? interval_ : 0; }
  return interval ? direction_ * 256 * TICKS_Hz / interval : 0;
}

bool TimerStepper::isMoving() const { return isMoving_; }

/* One step, and the time until the next one. Steps to standstill are as many as the ramp has had: with that many left,
   or with the target behind, it slows down. */
void TimerStepper::onCompare() {
  pulse();
  at_ += direction_;
  long left = direction_ * (target_ - at_);
  if (left <= (long)ramp_) {
    if (ramp_) {
      slowDown();
    } else if (left) {
      restart(direction_ * left);
    } else {
      TCCR1B = 0;
      isMoving_ = false;
      return;
    }
  } else if (left > (long)ramp_ + 1 && interval_ > least_) {
    speedUp();
  }
  OCR1A = (interval_ >> 8) - 1;
}

void TimerStepper::restart(long left) {
  direction_ = left < 0 ? -1 : 1;
  digitalWrite(dirPin_, left < 0 ? LOW : HIGH);
  interval_ = max(first_, least_);
  ramp_ = 0;
}

void TimerStepper::speedUp() {
  ramp_++;
  interval_ -= 2 * interval_ / (4UL * ramp_ + 1);
}

void TimerStepper::slowDown() {
  interval_ += 2 * interval_ / (4UL * ramp_ - 1);
  ramp_--;
}

void TimerStepper::pulse() {
  digitalWrite(stepPin_, HIGH);
  digitalWrite(stepPin_, LOW);
}
