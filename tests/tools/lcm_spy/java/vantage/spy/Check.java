package vantage.spy;

import java.lang.reflect.InvocationTargetException;
import java.lang.reflect.Method;

/** What the tests without a screen share. */
final class Check {
  private Check() {}

  /** Something that may throw. */
  interface Task {
    void run() throws Exception;
  }

  static void that(boolean holds, String otherwise) {
    if (!holds) {
      throw new AssertionError(otherwise);
    }
  }

  static void equal(Object found, Object expected) {
    that(expected.equals(found), "found " + found + ", expected " + expected);
  }

  /** Fails on NaN. */
  static void near(double found, double expected, double tolerance) {
    that(Math.abs(found - expected) <= tolerance, "found " + found + ", expected " + expected);
  }

  /** Refused with a sentence that holds the text. */
  static void refused(String text, Task task) throws Exception {
    try {
      task.run();
    } catch (IllegalArgumentException problem) {
      that(problem.getMessage().contains(text),
          "\"" + problem.getMessage() + "\" does not say \"" + text + "\"");
      return;
    }
    throw new AssertionError("not refused: " + text);
  }

  /** Runs every static method of a class whose name begins with "test"; ends the process. */
  static void runAll(Class<?> tests) throws IllegalAccessException {
    int failed = 0;
    int run = 0;
    for (Method test : tests.getDeclaredMethods()) {
      if (!test.getName().startsWith("test")) {
        continue;
      }
      run++;
      try {
        test.invoke(null);
        System.out.println("passed " + test.getName());
      } catch (InvocationTargetException problem) {
        failed++;
        System.out.println("FAILED " + test.getName());
        problem.getCause().printStackTrace(System.out);
      }
    }
    System.exit(failed == 0 && run > 0 ? 0 : 1);
  }
}
