#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Every topic, service and parameter of hector_slam, and those of the other packages that users of
launch files meet, is in doc/migration.md."""

import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

NAMES = {
    "From hector_mapping": """
        scan syscommand initialpose map map_metadata slam_out_pose poseupdate slam_cloud
        scanmatch_odom dynamic_map reset_map restart_mapping_with_new_pose pause_mapping
        base_frame map_frame odom_frame map_resolution map_size map_start_x map_start_y
        map_multi_res_levels update_factor_free update_factor_occupied map_update_distance_thresh
        map_update_angle_thresh map_pub_period laser_min_dist laser_max_dist laser_z_min_value
        laser_z_max_value scan_topic sys_msg_topic pose_update_topic scan_subscriber_queue_size
        use_tf_scan_transformation use_tf_pose_start_estimate map_with_known_poses pub_odometry
        pub_drawings pub_debug_output output_timing advertise_map_service pub_map_odom_transform
        pub_map_scanmatch_transform tf_map_scanmatch_transform_frame_name
        target_frame_name source_frame_name trajectory_update_rate trajectory_publish_rate
        trajectory trajectory_recovery_info map_file_path map_file_base_name geotiff_save_period
        draw_background_checkerboard draw_free_space_grid plugins get_distance_to_obstacle
        get_search_position map_image/full map_image/tile
        raw_imu ahrs rollpitch altimeter pressure_height magnetic fix fix_velocity twistupdate state
        pose velocity imu global geopose euler angular_velocity_bias linear_acceleration_bias
        sensor_pose fix/pose poseupdate/interpret_covariance_as_information_matrix""",
    "From gmapping": """
        base_frame map_frame odom_frame delta maxUrange maxRange linearUpdate angularUpdate
        map_update_interval tf_delay minimumScore transform_publish_period throttle_scans
        temporalUpdate xmin ymin xmax ymax particles resampleThreshold srr srt str stt sigma
        kernelSize lstep astep iterations lsigma ogain lskip llsamplerange llsamplestep
        lasamplerange lasamplestep occ_thresh map map_metadata dynamic_map ~entropy""",
    "From slam_toolbox": """
        map map_metadata pose dynamic_map save_map serialize_map deserialize_map
        pause_new_measurements reset clear_changes manual_loop_closure toggle_interactive_mode
        clear_queue clear_localization_buffer add_submap merge_submaps /initialpose
        minimum_travel_distance minimum_travel_heading minimum_time_interval map_update_interval
        transform_publish_period transform_timeout tf_buffer_duration max_laser_range resolution
        do_loop_closing position_covariance_scale yaw_covariance_scale""",
    "From cartographer_ros": """
        scan echoes points2 imu fix submap_list trajectory_node_list constraint_list
        landmark_poses_list scan_matched_points2 tracked_pose submap_query start_trajectory
        finish_trajectory write_state trajectory_query get_trajectory_states read_metrics""",
    "From scan_tools": """
        cloud imu/data odom vel pose2D pose_stamped pose_with_covariance
        pose_with_covariance_stamped kf_dist_linear kf_dist_angular max_iterations
        max_correspondence_dist restart do_compute_covariance cloud_ortho pose""",
}


class MigrationDocTest(unittest.TestCase):
    def test_every_name_is_there(self):
        text = (ROOT / "doc" / "migration.md").read_text()
        sections = dict(part.split("\n", 1) for part in text.split("\n## ")[1:])
        for section, names in NAMES.items():
            written = set(re.findall(r"[\w~/]+", " ".join(re.findall(r"`([^`]+)`", sections[section]))))
            missing = [name for name in names.split() if name not in written]
            with self.subTest(section=section):
                self.assertEqual(missing, [])

    def test_what_is_not_there_has_a_reason(self):
        text = (ROOT / "doc" / "migration.md").read_text()
        self.assertEqual(re.findall(r"^.*\| *no *\|$", text, re.MULTILINE), [])


if __name__ == "__main__":
    unittest.main()
