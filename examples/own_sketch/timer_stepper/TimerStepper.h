/* A stepper with an acceleration, driven by Timer 1: each step is an interrupt, the program goes on meanwhile.

   Intervals follow D. Austin, "Generate stepper-motor speed profiles in real time" (2005): with c the interval before
   step n of a ramp, the next one is c - 2 c / (4 n + 1). No square root and no floating point in the interrupt. */
#ifndef TIMER_STEPPER_H
#define TIMER_STEPPER_H

#include <Arduino.h>

class TimerStepper {
 public:
  TimerStepper(byte stepPin, byte dirPin);
  void begin();
  void setAcceleration(float stepsPerS2); // 860 and more: an interval has 16 bits of 0.5 us
  void setMaxSpeed(float stepsPerS);      // 31 to 8000
  void moveTo(long target);               // also while it moves: it slows down and turns round where it has to
  long position() const;                  // steps that were made, with their sign
  float speed() const;                    // steps a second, now
  bool isMoving() const;
  void onCompare();                       // the interrupt's

 private:
  void restart(long left);
  void slowDown();
  void speedUp();
  void pulse();

  const byte stepPin_, dirPin_;
  unsigned long first_, least_;           // intervals in 1/256 of 0.5 us: from standstill, at full speed
  volatile unsigned long interval_ = 0;
  volatile unsigned int ramp_ = 0;        // steps from here down to standstill
  volatile long at_ = 0, target_ = 0;
  volatile int direction_ = 1;
  volatile bool isMoving_ = false;
};

#endif
