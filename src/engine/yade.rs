//! The YADE driver.
